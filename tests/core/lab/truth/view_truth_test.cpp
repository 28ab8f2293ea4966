// Claims about comparing cameras by where they look: what no picture can say is no error, and each error has
// its number.
#include "core/lab/truth/view_truth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr double kDegreeInRad = std::numbers::pi / 180;

// A camera that a hand turns and that zooms by a tenth.
CameraSet held(int count) {
  CameraSet set;
  set.kind = CameraKind::walking;
  for (int i = 0; i < count; ++i) {
    const double focal = 700 * (1 + 0.05 * std::sin(0.3 * i));
    Camera camera{i, {640, 480, focal, focal, 320, 240}, Pose::Identity()};
    camera.cam_from_world.linear() = turn_from_vector(
        kDegreeInRad * Vec3d(2 * std::sin(0.21 * i), 3 * std::sin(0.13 * i + 1), std::cos(0.17 * i)));
    set.cameras.push_back(camera);
  }
  return set;
}

TEST(CompareViews, ATurnOfTheWorldAndAnotherLengthOfTheLensAreMeasuredApart) {
  const CameraSet truth = held(30);
  CameraSet found = truth;
  for (Camera& camera : found.cameras) {
    camera.cam_from_world.linear() =
        camera.cam_from_world.linear() * rotation_about(Vec3d(1, 2, 3).normalized(), 0.8);
    camera.intrinsics.fx *= 1.03, camera.intrinsics.fy *= 1.03;
  }
  const auto errors = compare_views(found, truth, {});
  ASSERT_TRUE(errors.has_value());
  EXPECT_EQ(errors->found, 30);
  EXPECT_LT(errors->turn_max_deg, 1e-6);
  EXPECT_LT(errors->zoom_max_percent, 1e-9);
  EXPECT_NEAR(errors->focal_percent, 3, 1e-9);
  // The wrong lens turns what it sees by the wrong angle: three percent of some degrees.
  EXPECT_GT(errors->mapping_p95_px, 0.3);
  EXPECT_LT(errors->mapping_p95_px, 6);
  EXPECT_LT(compare_views(truth, truth, {})->mapping_p95_px, 1e-9);
}

TEST(CompareViews, EachFramesOwnTurnAndZoomAreItsErrors) {
  const CameraSet truth = held(40);
  CameraSet found = truth;
  for (Camera& camera : found.cameras) {
    const double sign = camera.frame % 2 ? 1 : -1;
    camera.cam_from_world.linear() =
        rotation_about(Vec3d::UnitY(), sign * 0.2 * kDegreeInRad) * camera.cam_from_world.linear();
    camera.intrinsics.fx *= 1 + 0.01 * sign;
  }
  const auto errors = compare_views(found, truth, {});
  ASSERT_TRUE(errors.has_value());
  EXPECT_NEAR(errors->turn_median_deg, 0.2, 1e-2);
  EXPECT_NEAR(errors->zoom_max_percent, 2, 0.1);  // against the median, which is one of the two
  // Half of the frames err like their place's first one, and fit together with it; the others by twice their
  // turn.
  EXPECT_GT(errors->mapping_p95_px, 700 * 0.4 * kDegreeInRad * 0.5);
}

TEST(CompareViews, EveryPlaceHasItsOwnWorld) {
  const CameraSet truth = held(40);
  CameraSet found = truth;
  for (Camera& camera : found.cameras)
    if (camera.frame >= 20)
      camera.cam_from_world.linear() = camera.cam_from_world.linear() * rotation_about(Vec3d::UnitX(), 0.5);
  const std::vector<TrueShot> shots = {{0, 19, "opening", 0, 0}, {20, 39, "angle", 1, 2}};
  EXPECT_LT(compare_views(found, truth, shots)->turn_max_deg, 1e-6);
  EXPECT_GT(compare_views(found, truth, {})->turn_median_deg, 10);
}

TEST(CompareViews, LostFramesAreCountedAndSizesMayDiffer) {
  const CameraSet truth = held(12);
  CameraSet found = truth;
  found.cameras.resize(7);
  for (Camera& camera : found.cameras) camera = resized(camera, 320);
  const auto errors = compare_views(found, truth, {});
  ASSERT_TRUE(errors.has_value());
  EXPECT_EQ(errors->wanted, 12);
  EXPECT_EQ(errors->found, 7);
  EXPECT_NEAR(errors->focal_percent, 0, 1e-9);
  EXPECT_LT(errors->mapping_p95_px, 1e-9);
  EXPECT_FALSE(compare_views(CameraSet{}, truth, {}).has_value());
}

TEST(CompareViews, ARestingCameraIsFoundWhereverItStands) {
  CameraSet truth, found;
  truth.cameras.push_back({-1, {640, 480, 700, 700, 320, 240}, Pose::Identity()});
  found.cameras.push_back({-1, {640, 480, 770, 770, 320, 240}, Pose::Identity()});
  const auto errors = compare_views(found, truth, {});
  ASSERT_TRUE(errors.has_value());
  EXPECT_NEAR(errors->focal_percent, 10, 1e-9);
  EXPECT_EQ(errors->turn_max_deg, 0);
  // Taken for resting, a turning camera is wrong by its turn.
  EXPECT_GT(compare_views(found, held(30), {})->turn_median_deg, 0.5);
}

}  // namespace
}  // namespace likeness
