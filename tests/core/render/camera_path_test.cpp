// Claims about orbits, head turns and articulations.
#include "core/render/camera_path.h"

#include <gtest/gtest.h>

#include "core/base/rigid.h"
#include "tests/core/render/tiny_avatar.h"

namespace likeness {
namespace {

TEST(OrbitCamera, KeepsTheHeadInItsPlaceAtItsDistance) {
  const Avatar a = tiny_avatar();
  const Vec3d centre = a.world_from_head * head_centre(a);
  const Vec3d before = a.cam_from_world * centre;
  for (const double yaw : {-0.5, 0.0, 0.3})
    for (const double pitch : {-0.2, 0.0, 0.2}) {
      const Camera camera = orbit_camera(a, a.world_from_head, yaw, pitch);
      EXPECT_LT((camera.cam_from_world * centre - before).norm(), 1e-12);
      EXPECT_NEAR(camera.cam_from_world.linear().determinant(), 1, 1e-12);
    }
}

TEST(OrbitCamera, TurnsByExactlyTheRequestedAngle) {
  const Avatar a = tiny_avatar();
  const Camera camera = orbit_camera(a, a.world_from_head, 0.5);
  const Mat3d turn = a.cam_from_world.linear() * camera.cam_from_world.linear().transpose();
  EXPECT_NEAR(rotation_angle(turn), 0.5, 1e-9);
}

TEST(OrbitCamera, PositiveYawMovesTheCameraToTheSubjectsLeftAndPositivePitchUp) {
  Avatar a = tiny_avatar();  // a head that faces the camera: x left, y up, z towards the camera
  a.world_from_head = Pose::Identity();
  a.world_from_head.linear() = Vec3d(1, -1, -1).asDiagonal();
  a.world_from_head.translation() = Vec3d(0, 0, 0.8);
  const auto camera_in_head = [&](double yaw, double pitch) -> Vec3d {
    return inverse(a.world_from_head) *
           inverse(orbit_camera(a, a.world_from_head, yaw, pitch).cam_from_world).translation();
  };
  EXPECT_GT(camera_in_head(0.4, 0).x(), 0.2);
  EXPECT_GT(camera_in_head(0, 0.4).y(), 0.2);
}

TEST(TurnedHead, KeepsItsPivot) {
  const Avatar a = tiny_avatar();
  const Vec3d pivot(0, -0.08, -0.01);
  const Pose turned = turned_head(a.world_from_head, pivot, 0.4, -0.2, 0.1);
  EXPECT_LT((turned * pivot - a.world_from_head * pivot).norm(), 1e-12);
}

TEST(OrbitYaws, StartAndEndStraightAhead) {
  const auto yaws = orbit_yaws(steady_times(61, 25), -0.2, 0.5);
  EXPECT_NEAR(yaws.front(), 0, 1e-12);
  EXPECT_NEAR(yaws.back(), 0, 1e-12);
  EXPECT_NEAR(*std::max_element(yaws.begin(), yaws.end()), 0.5, 1e-3);
  EXPECT_NEAR(*std::min_element(yaws.begin(), yaws.end()), -0.2, 1e-3);
}

TEST(Articulate, AddsNamedActionsAndRefusesUnknownOnes) {
  HeadModel model;
  model.name = "test";
  model.actions.push_back({"jawOpen", Eigen::VectorXf::Unit(3, 1), Vec3f(0.4f, 0, 0)});
  Articulation neutral;
  neutral.expression = Eigen::VectorXf::Constant(3, 0.1f);
  const auto half = articulate(model, neutral, {{"jawOpen", 0.5f}});
  ASSERT_TRUE(half.ok());
  EXPECT_FLOAT_EQ(half->expression[1], 0.6f);
  EXPECT_FLOAT_EQ(half->expression[0], 0.1f);
  EXPECT_FLOAT_EQ(half->jaw.x(), 0.2f);
  const auto unknown = articulate(model, neutral, {{"jawOpne", 1.f}});
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().fix.find("jawOpen"), std::string::npos);
}

TEST(Articulate, AnActionOfTheEyesTurnsTheEyeballs) {
  HeadModel model;
  NamedAction look{"eyeLookUp_L", Eigen::VectorXf::Zero(1)};
  look.left_eye = Vec3f(-0.4f, 0, 0);
  model.actions = {look};
  Articulation neutral;
  neutral.expression = Eigen::VectorXf::Zero(1);
  const auto half = articulate(model, neutral, {{"eyeLookUp_L", 0.5f}});
  ASSERT_TRUE(half.ok());
  EXPECT_FLOAT_EQ(half->left_eye.x(), -0.2f);
  EXPECT_EQ(half->right_eye, Vec3f::Zero());
}

}  // namespace
}  // namespace likeness
