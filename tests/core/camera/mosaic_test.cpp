// Claims about cameras at one place: what one sees of another's picture, and the picture that holds what all
// see.
#include "core/camera/mosaic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace likeness {
namespace {

Camera turned(double yaw, double pitch, double zoom = 1) {
  Camera camera;
  camera.intrinsics = {.width = 120, .height = 90, .fx = 150 * zoom, .fy = 150 * zoom, .cx = 61, .cy = 44};
  camera.cam_from_world.linear() =
      (Eigen::AngleAxisd(pitch, Vec3d::UnitX()) * Eigen::AngleAxisd(yaw, Vec3d::UnitY())).toRotationMatrix();
  return camera;
}

// Of a direction in the world.
Vec3d colour_of(const Vec3d& direction) {
  const Vec3d d = direction / direction.z();
  return {127 + 90 * std::sin(4 * d.x()), 127 + 90 * std::cos(3 * d.y() + d.x()),
          127 + 90 * std::sin(5 * d.y())};
}

Image8 picture_of(const Camera& camera) {
  Image8 picture(camera.intrinsics.width, camera.intrinsics.height, 3);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const Vec3d in_camera = ray_direction(camera.intrinsics, Vec2d(x + 0.5, y + 0.5));
      const Vec3d colour = colour_of(camera.cam_from_world.linear().transpose() * in_camera);
      for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = std::uint8_t(std::lround(colour[c]));
    }
  return picture;
}

TEST(Mosaic, PixelsGoWhereTheirDirectionsAreSeen) {
  const Camera from = turned(0.1, -0.05), to = turned(-0.12, 0.08, 1.2);
  const Mat3d map = pixels_between(from, to);
  for (const Vec2d& pixel : {Vec2d(3, 80), Vec2d(60, 45), Vec2d(117, 2)}) {
    const Vec3d world = from.cam_from_world.linear().transpose() * ray_direction(from.intrinsics, pixel);
    const Vec2d expected = project<double>(to.intrinsics, Vec3d(to.cam_from_world.linear() * world));
    const Vec3d at = map * Vec3d(pixel.x(), pixel.y(), 1);
    EXPECT_NEAR((Vec2d(at.x() / at.z(), at.y() / at.z()) - expected).norm(), 0, 1e-9);
  }
}

TEST(Mosaic, HoldsWhatEveryCameraSees) {
  const std::vector<Camera> cameras{turned(-0.2, 0), turned(0.2, 0.1), turned(0, -0.1, 0.9)};
  const Camera whole = mosaic_camera(cameras, 1, 1u << 20);
  const Mosaic mosaic{picture_of(whole), {}, whole};
  for (const Camera& camera : cameras) {
    Image8 known;
    const Image8 seen = mosaic_seen_by(mosaic, camera, &known), truth = picture_of(camera);
    int worst = 0;
    for (std::size_t i = 0; i < truth.data.size(); ++i)
      worst = std::max(worst, std::abs(int(seen.data[i]) - int(truth.data[i])));
    EXPECT_LE(worst, 3);
    // The outermost ring may fall between the mosaic's last pixel centres.
    std::size_t all = 0;
    for (const std::uint8_t k : known.data) all += k == 255;
    EXPECT_GT(double(all), 0.95 * double(known.data.size()));
  }
}

TEST(Mosaic, KnowsWhereItWasSeen) {
  const Camera camera = turned(0, 0);
  Mosaic mosaic{picture_of(camera), Image8(120, 90, 1, 255), camera};
  mosaic.known.at(50, 40)[0] = 128;  // a guess
  Image8 known;
  mosaic_seen_by(mosaic, camera, &known);
  EXPECT_EQ(known.at(50, 40)[0], 0);
  EXPECT_EQ(known.at(70, 40)[0], 255);
  mosaic_seen_by(mosaic, turned(std::numbers::pi / 8, 0), &known);  // looks past it on one side
  EXPECT_TRUE((known.at(1, 45)[0] == 0) != (known.at(118, 45)[0] == 0));
}

TEST(Mosaic, IsCutWhereAPinholesPictureGrowsWithoutBound) {
  std::vector<Camera> cameras;
  for (int i = -8; i <= 8; ++i) cameras.push_back(turned(0.2 * i, 0));  // most of a circle
  const double reach = 0.9;
  const Camera whole = mosaic_camera(cameras, reach, 200'000);
  const Intrinsics& k = whole.intrinsics;
  EXPECT_LE(std::size_t(k.width) * std::size_t(k.height), 205'000u);
  EXPECT_LE(std::atan(k.cx / k.fx), reach + 1e-3);
  EXPECT_LE(std::atan((k.width - k.cx) / k.fx), reach + 2e-2);
}

}  // namespace
}  // namespace likeness
