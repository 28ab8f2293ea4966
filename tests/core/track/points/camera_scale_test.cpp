// Claims about the metre of an arbitrary-scale camera solve.
#include "core/track/points/camera_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/rigid.h"

namespace likeness {
namespace {

// A camera on an arc of `radius` metres round a head for `moving` of 240 frames; the head itself moves only
// afterwards, as in a capture of two parts. Camera positions are given in units of `metres_per_unit`.
std::vector<HeadSighting> arc(double radius, double sweep, double metres_per_unit, double noise_m,
                              int moving = 120) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, noise_m);
  std::vector<HeadSighting> sightings;
  for (int i = 0; i < 240; ++i) {
    const double angle = sweep * std::min(1.0, i / static_cast<double>(moving));
    Pose world_from_cam = Pose::Identity();
    world_from_cam.linear() = rotation_about(Vec3d::UnitY(), angle);
    world_from_cam.translation() = Vec3d(0.2, 0.1, radius) - radius * world_from_cam.linear().col(2);
    Pose world_from_head = Pose::Identity();
    world_from_head.translation() = Vec3d(0.2, 0.1, radius);
    if (i > moving) world_from_head.translation() += 0.04 * Vec3d(std::sin(i * 0.1), std::cos(i * 0.07), 0);
    HeadSighting s;
    s.cam_from_head = inverse(world_from_cam) * world_from_head;
    s.cam_from_head.translation() += Vec3d(normal(random), normal(random), 3 * normal(random));
    s.cam_from_world = inverse(world_from_cam);
    s.cam_from_world.translation() /= metres_per_unit;
    sightings.push_back(s);
  }
  return sightings;
}

TEST(CameraScale, RecoversTheMetreOfAnyScale) {
  for (double truth : {0.01, 0.37, 1.0, 12.0}) {
    const auto found = steady_metres_per_unit(arc(0.6, 1.0, truth, 0.002));
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(*found / truth, 1.0, 0.03);
  }
}

TEST(CameraScale, RecoversTheMetreOfACaptureThatMostlyRests) {
  for (int moving : {40, 60, 84}) {
    const auto found = steady_metres_per_unit(arc(0.6, 1.0, 0.37, 0.002, moving));
    ASSERT_TRUE(found.has_value()) << moving;
    EXPECT_NEAR(*found / 0.37, 1.0, 0.05) << moving;
  }
}

TEST(CameraScale, IsUnknownForAStillCamera) {
  EXPECT_FALSE(steady_metres_per_unit(arc(0.6, 0.0, 0.5, 0.002)).has_value());
  EXPECT_FALSE(steady_metres_per_unit(arc(0.6, 0.0005, 0.5, 0.004)).has_value());
}

}  // namespace
}  // namespace likeness
