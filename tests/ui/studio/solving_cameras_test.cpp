// Claims about a camera solve being watched: however the solve is turned and scaled, it is shown upright and
// of one size.
#include "ui/studio/solving_cameras.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rigid.h"

namespace likeness::ui {
namespace {

// Cameras on an arc about a point that they look at, upright; then the whole turned, scaled and moved, as a
// solve comes out.
ColmapModel arc(int count, const Pose& turned, double scale) {
  ColmapModel model;
  model.cameras[1] = {540, 360, 500, 500, 270, 180, 0, 0, 0, 0};
  for (int i = 0; i < count; ++i) {
    const double angle = 0.3 * (i - 0.5 * (count - 1));
    Pose world_from_cam = Pose::Identity();
    world_from_cam.rotate(rotation_about(Vec3d::UnitY(), angle));
    world_from_cam.rotate(rotation_about(Vec3d::UnitX(), M_PI));  // y down, looks along -z
    world_from_cam.translation() = Vec3d(std::sin(angle), 0, std::cos(angle));
    ColmapImage image;
    image.camera = 1;
    Pose placed = turned * world_from_cam;
    placed.translation() *= scale;
    image.cam_from_world = inverse(placed);
    model.images.push_back(image);
  }
  for (int i = 0; i < 9000; ++i)
    model.points[i] = {scale * (turned * Vec3d(0.01 * (i % 100), 0.01 * (i / 100), -1)), 0.5, 3};
  model.points[9000] = {scale * Vec3d(1e6, 0, 0), 0.5, 3};
  return model;
}

TEST(SolvingCameras, StandUprightAboutTheirMiddleWhateverTheSolve) {
  Pose turned = Pose::Identity();
  turned.rotate(rotation_about(Vec3d(0.3, -1, 0.5).normalized(), 2.1)).translate(Vec3d(4, -7, 2));
  for (const auto& model : {arc(9, Pose::Identity(), 1), arc(9, turned, 37)}) {
    const auto solving = solving_cameras(model);
    ASSERT_NE(solving, nullptr);
    ASSERT_EQ(solving->cameras.size(), 9u);
    Vec3d middle = Vec3d::Zero();
    std::vector<double> radii;
    for (const auto& camera : solving->cameras) {
      middle += camera.world_from_cam.translation() / 9;
      radii.push_back(camera.world_from_cam.translation().norm());
      EXPECT_NEAR(-camera.world_from_cam.linear().col(1).y(), 1, 1e-6);
      EXPECT_NEAR(std::abs(camera.world_from_cam.linear().determinant()), 1, 1e-9);
    }
    EXPECT_LT(middle.norm(), 1e-6);
    std::ranges::sort(radii);
    EXPECT_NEAR(radii[4], 0.5, 1e-6);
    EXPECT_GT(solving->points.size(), kSolvingPoints / 2);
    EXPECT_LE(solving->points.size(), kSolvingPoints);
    EXPECT_GT(solving->reach, 0.5);
    EXPECT_LE(solving->reach, 3);
    for (const Vec3d& point : solving->points) EXPECT_LT(point.norm(), 10);  // none from the end of the world
  }
}

TEST(SolvingCameras, AreNoneWithoutAPath) {
  EXPECT_EQ(solving_cameras({}), nullptr);
  EXPECT_EQ(solving_cameras(arc(1, Pose::Identity(), 1)), nullptr);
  ColmapModel at_one_place = arc(1, Pose::Identity(), 1);
  at_one_place.images.push_back(at_one_place.images.front());
  EXPECT_EQ(solving_cameras(at_one_place), nullptr);
  ColmapModel without_lens = arc(3, Pose::Identity(), 1);
  without_lens.cameras.clear();
  EXPECT_EQ(solving_cameras(without_lens), nullptr);
  EXPECT_EQ(read_solving_cameras("/no/such/folder"), nullptr);
}

}  // namespace
}  // namespace likeness::ui
