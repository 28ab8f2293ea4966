// Claims about following corners.
#include "core/track/points/point_tracks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace likeness {
namespace {

// Smooth random texture moved by (dx, dy) pixels, analytically, so that the truth is exact.
Image8 moved_texture(double dx, double dy) {
  static const std::vector<std::array<double, 4>> waves = [] {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> u(-0.5, 0.5);
    std::vector<std::array<double, 4>> list(40);
    for (auto& w : list) w = {1.2 * u(random), 1.2 * u(random), 6.28 * u(random), 14.0};
    return list;
  }();
  Image8 image(160, 140, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      double v = 128;
      for (const auto& w : waves) v += w[3] * std::sin(w[0] * (x - dx) + w[1] * (y - dy) + w[2]);
      image.at(x, y)[0] = static_cast<std::uint8_t>(std::clamp(v, 0.0, 255.0));
    }
  return image;
}

TEST(PointTracks, FollowAMovingTextureToATenthOfAPixel) {
  std::vector<Image8> images;
  for (int i = 0; i < 16; ++i) images.push_back(moved_texture(1.3 * i, -0.7 * i));
  std::vector<const Image8*> grey;
  std::vector<int> order;
  for (int i = 0; i < 16; ++i) grey.push_back(&images[i]), order.push_back(i);
  const auto mask = [](int) {
    Image8 m(160, 140, 1);
    for (int y = 20; y < 120; ++y)
      for (int x = 10; x < 125; ++x) m.at(x, y)[0] = 255;
    return m;
  };
  const auto tracks = track_points(grey, order, mask, {}, {}, {});
  ASSERT_TRUE(tracks.ok());
  ASSERT_GT(tracks->size(), 20u);
  std::vector<double> errors;
  for (const PointTrack& t : *tracks) {
    EXPECT_GE(t.seen.size(), 12u);
    const int steps = t.seen.back().picture - t.seen.front().picture;
    errors.push_back((t.seen.back().pixel - t.seen.front().pixel - Vec2d(1.3, -0.7) * steps).norm());
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.15);
}

TEST(PointTracks, EndAtACut) {
  // One texture throughout, so that nothing but the shots keeps a point from going on.
  std::vector<Image8> images;
  for (int i = 0; i < 32; ++i) images.push_back(moved_texture(0.5 * i, 0));
  std::vector<const Image8*> grey;
  std::vector<int> order, shots;
  for (int i = 0; i < 32; ++i)
    grey.push_back(&images[i]), order.push_back(i), shots.push_back(i < 16 ? 0 : 1);
  const auto across = [&](const std::vector<int>& of) {
    const auto tracks = track_points(
        grey, order, [](int) { return Image8(160, 140, 1, 255); }, {}, {}, {}, of);
    EXPECT_TRUE(tracks.ok());
    int here = 0, beyond = 0;
    for (const PointTrack& t : *tracks)
      (t.seen.back().picture < 16 || t.seen.front().picture >= 16 ? here : beyond)++;
    EXPECT_GT(here + beyond, 20);
    return beyond;
  };
  EXPECT_GT(across({}), 0);
  EXPECT_EQ(across(shots), 0);
}

TEST(PointTracks, LeaveNoPointOutsideTheMask) {
  const Image8 image = moved_texture(0, 0);
  const TrackPicture picture(image);
  Image8 mask(160, 140, 1);
  for (int y = 40; y < 80; ++y)
    for (int x = 50; x < 90; ++x) mask.at(x, y)[0] = 255;
  const auto corners = find_corners(picture, mask, {}, 100, {});
  ASSERT_FALSE(corners.empty());
  for (const Vec2d& c : corners) EXPECT_TRUE(c.x() >= 50 && c.x() <= 90 && c.y() >= 40 && c.y() <= 80);
}

}  // namespace
}  // namespace likeness
