// A textured plane seen by a turned camera: its patches are found where they are, not where followed points
// drift to.
#include "core/track/points/patch_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr int kPlaneSize = 160;

Intrinsics plane_camera() {
  Intrinsics k;
  k.width = k.height = kPlaneSize;
  k.fx = k.fy = 300;
  k.cx = k.cy = kPlaneSize / 2.0;
  return k;
}

// Grain of several sizes on the plane z = 0 of the head frame.
double grain(double x, double y) {
  double sum = 0;
  for (int i = 0; i < 24; ++i) {
    const double turn = i * 2.4, rate = 150 + 35 * i;
    sum += std::sin(rate * (x * std::cos(turn) + y * std::sin(turn)) + 1.7 * i * i);
  }
  return sum / 5;
}

// gain, offset: the light changes as the head turns.
Image8 picture_of_plane(const Pose& cam_from_head, double gain, double offset, double grain_shift = 0) {
  const Intrinsics k = plane_camera();
  const Pose head_from_cam = inverse(cam_from_head);
  Image8 picture(kPlaneSize, kPlaneSize, 1);
  for (int y = 0; y < kPlaneSize; ++y)
    for (int x = 0; x < kPlaneSize; ++x) {
      double value = 0;
      for (int s = 0; s < 4; ++s) {
        const Vec2d px(x + 0.25 + 0.5 * (s % 2), y + 0.25 + 0.5 * (s / 2));
        const Vec3d d = head_from_cam.linear() * ray_direction(k, px), o = head_from_cam.translation();
        const double t = -o.z() / d.z();
        const Vec3d p = o + t * d;
        value += 0.25 * grain(p.x() + grain_shift, p.y());
      }
      *picture.at(x, y) = static_cast<std::uint8_t>(std::clamp(offset + gain * 40 * value + 128, 0.0, 255.0));
    }
  return picture;
}

// The plane faces the camera (OpenCV: z away from it) at zero turn.
Pose pose(double yaw_deg, double pitch_deg, double shift_m) {
  Pose p = Pose::Identity();
  const double rad = std::acos(-1.0) / 180;
  p.linear() =
      turn_from_vector({pitch_deg * rad, yaw_deg * rad, 0}) * turn_from_vector({std::acos(-1.0), 0, 0});
  p.translation() = Vec3d(shift_m, 0, 0.5);
  return p;
}

struct PlaneScene {
  Image8 from_picture, to_picture;
  PatchPicture from, to;
  Pose from_pose, to_pose;
  HeadPatch patch;

  PlaneScene(double yaw_deg, double gain, double offset, double grain_shift = 0)
      : from_pose(pose(0, 0, 0)), to_pose(pose(yaw_deg, 8, 0.01)) {
    from_picture = picture_of_plane(from_pose, 1, 0);
    to_picture = picture_of_plane(to_pose, gain, offset, grain_shift);
    from = patch_picture(from_picture);
    to = patch_picture(to_picture);
    patch.point = Vec3d(0.012, -0.008, 0);
    patch.normal = Vec3d(0, 0, 1);
    patch.reference = 0;
    patch.pixel = project<double>(plane_camera(), from_pose * patch.point);
  }
  std::optional<PatchMatch> find(const Pose& predicted, double reach) const {
    return find_patch(patch, {&from, plane_camera(), from_pose}, {&to, plane_camera(), predicted}, reach);
  }
  Vec2d truth() const { return project<double>(plane_camera(), to_pose * patch.point); }
};

TEST(PatchSearch, FindsARotatedAndRelitPatchToATenthOfAPixel) {
  for (double yaw : {-35.0, 0.0, 20.0, 40.0}) {
    const PlaneScene scene(yaw, 0.6, 20);
    Pose predicted = scene.to_pose;
    predicted.translation() += Vec3d(0.006, -0.004, 0);  // 4 px off
    predicted.linear() = turn_from_vector({0.01, 0.03, 0}) * predicted.linear();
    const auto match = scene.find(predicted, 10);
    ASSERT_TRUE(match) << yaw;
    EXPECT_LT((match->pixel - scene.truth()).norm(), 0.12) << yaw;
    EXPECT_GT(match->correlation, 0.9) << yaw;
  }
}

TEST(PatchSearch, RefusesAnotherTexture) {
  const PlaneScene scene(15, 1, 0, 0.3);
  EXPECT_FALSE(scene.find(scene.to_pose, 8));
}

TEST(PatchSearch, RefusesWhatLiesFurtherThanTheReach) {
  const PlaneScene scene(10, 1, 0);
  Pose predicted = scene.to_pose;
  predicted.translation() += Vec3d(0.012, 0, 0);  // 7 px off
  EXPECT_FALSE(scene.find(predicted, 4));
}

TEST(PatchSearch, RefusesAPatchSeenFromTheSideOrFromBehind) {
  const PlaneScene scene(10, 1, 0);
  EXPECT_FALSE(scene.find(pose(75, 0, 0), 8));
  EXPECT_LT(patch_facing(scene.patch, pose(180, 0, 0)), 0);
  EXPECT_NEAR(patch_facing(scene.patch, pose(0, 0, 0)), 1, 0.01);
}

TEST(PatchSearch, RefusesAFlatPicture) {
  PlaneScene scene(0, 1, 0);
  scene.from_picture = Image8(kPlaneSize, kPlaneSize, 1, std::uint8_t(90));
  scene.from = patch_picture(scene.from_picture);
  EXPECT_FALSE(scene.find(scene.to_pose, 8));
}

}  // namespace
}  // namespace likeness
