// Claims about projection, its inverse, crops and the look-up of cameras.
#include "core/camera/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/camera/assumed_lens.h"

namespace likeness {
namespace {

Intrinsics phone_lens() {
  Intrinsics k;
  k.width = 1080, k.height = 1920;
  k.fx = 1375, k.fy = 1374, k.cx = 554, k.cy = 965;
  k.k1 = 0.0578, k.k2 = -0.0805, k.p1 = -0.00098, k.p2 = 0.00016;
  return k;
}

TEST(Camera, RayDirectionInvertsProjectionOverTheWholePicture) {
  Intrinsics barrel = phone_lens();
  barrel.k1 = -0.12, barrel.k2 = 0.02, barrel.p1 = 0.003, barrel.p2 = -0.002;
  for (const Intrinsics& k : {phone_lens(), barrel})
    for (double x = 0; x <= k.width; x += 54)
      for (double y = 0; y <= k.height; y += 64) {
        const Vec3d ray = ray_direction(k, {x, y});
        EXPECT_DOUBLE_EQ(ray.z(), 1);
        EXPECT_LT((project<double>(k, ray * 0.7) - Vec2d(x, y)).norm(), 1e-6) << x << "," << y;
      }
}

TEST(Camera, RayThroughThePrincipalPointIsTheOpticalAxis) {
  const Intrinsics k = phone_lens();
  EXPECT_LT((ray_direction(k, {k.cx, k.cy}) - Vec3d(0, 0, 1)).norm(), 1e-12);
}

TEST(Camera, RayDirectionStaysFiniteWhereDistortionFoldsBack) {
  Intrinsics k = phone_lens();
  k.k1 = -0.9, k.k2 = 0;
  const Vec3d ray = ray_direction(k, {0, 0});
  EXPECT_TRUE(std::isfinite(ray.x()) && std::isfinite(ray.y()));
}

TEST(Camera, CropMapsPixelsByShiftAndScale) {
  const Intrinsics k = phone_lens();
  const double x = -40, y = 300, side = 900;  // reaches beyond the left border
  const int size = 256;
  const Intrinsics cropped = crop_intrinsics(k, x, y, side, size);
  EXPECT_EQ(cropped.width, size);
  EXPECT_EQ(cropped.height, size);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> offset(-0.3, 0.3);
  for (int i = 0; i < 100; ++i) {
    const Vec3d point(offset(random), offset(random), 1.0);
    const Vec2d expected = (project<double>(k, point) - Vec2d(x, y)) * (size / side);
    EXPECT_LT((project<double>(cropped, point) - expected).norm(), 1e-9);
  }
}

TEST(Camera, CropOfTheWholeSquareKeepsCornersAtCorners) {
  Intrinsics k;
  k.width = k.height = 512;
  k.fx = k.fy = 1000, k.cx = 256, k.cy = 256;
  const Intrinsics cropped = crop_intrinsics(k, 0, 0, 512, 128);
  const Vec3d corner = ray_direction(k, {512, 512});
  EXPECT_LT((project<double>(cropped, corner) - Vec2d(128, 128)).norm(), 1e-9);
}

TEST(FindCamera, StaticSetServesEveryFrameAndMovingSetOnlyItsOwn) {
  CameraSet fixed;
  fixed.cameras.push_back({-1, phone_lens(), Pose::Identity()});
  EXPECT_EQ(find_camera(fixed, 0), &fixed.cameras[0]);
  EXPECT_EQ(find_camera(fixed, 12345), &fixed.cameras[0]);
  CameraSet moving;
  moving.kind = CameraKind::walking;
  for (int frame : {2, 3, 7}) moving.cameras.push_back({frame, phone_lens(), Pose::Identity()});
  ASSERT_NE(find_camera(moving, 7), nullptr);
  EXPECT_EQ(find_camera(moving, 7)->frame, 7);
  for (int absent : {0, 4, 8}) EXPECT_EQ(find_camera(moving, absent), nullptr);
  EXPECT_EQ(find_camera(CameraSet{}, 0), nullptr);
}

TEST(AssumedLens, IsTheSameHoweverThePhoneIsHeld) {
  const Intrinsics upright = assumed_intrinsics(1080, 1920, 0), across = assumed_intrinsics(1920, 1080, 0);
  EXPECT_DOUBLE_EQ(upright.fx, 1512);
  EXPECT_DOUBLE_EQ(across.fx, upright.fx);
  EXPECT_DOUBLE_EQ(across.fy, across.fx);
  EXPECT_DOUBLE_EQ(across.cx, 960);
  EXPECT_DOUBLE_EQ(across.cy, 540);
  EXPECT_DOUBLE_EQ(assumed_intrinsics(512, 512, 0).fx, 1024);
}

TEST(AssumedLens, IsTheFilmsOwnWhereItIsRecorded) {
  EXPECT_DOUBLE_EQ(assumed_intrinsics(1920, 1080, 27).fx, 1440);
  EXPECT_DOUBLE_EQ(assumed_intrinsics(1080, 1920, 27).fx, 1440);
  EXPECT_DOUBLE_EQ(assumed_intrinsics(1440, 1080, 27).fx, 1080);
  EXPECT_DOUBLE_EQ(assumed_intrinsics(512, 512, 27).fx, 1024);  // was cropped
  EXPECT_DOUBLE_EQ(film_intrinsics(512, 512, 27).fx, 384);
  EXPECT_DOUBLE_EQ(assumed_intrinsics(300, 1000, 27).fx, 600);
}

}  // namespace
}  // namespace likeness
