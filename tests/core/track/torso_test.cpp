// Claims about the torso: a textured board in the camera's view below the chin.
#include "core/track/torso.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/track/fit_frame.h"
#include "tests/core/track/synthetic_face.h"

namespace likeness {
namespace {

constexpr double kDepth = 0.66;  // m, where track_torso expects a chest whose head is at 0.7

Intrinsics view() { return {256, 256, 400, 400, 128, 128}; }

// The board turned by `roll` in the picture about (0, 0.1) and moved by (dx, dy) metres.
Image8 board(double dx, double dy, double roll) {
  const Intrinsics k = view();
  Image8 image(k.width, k.height, 1);
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const double bx = (x + 0.5 - k.cx) / k.fx * kDepth - dx,
                   by = (y + 0.5 - k.cy) / k.fy * kDepth - dy - 0.1;
      const double u = std::cos(roll) * bx + std::sin(roll) * by,
                   v = -std::sin(roll) * bx + std::cos(roll) * by;
      const double value = 128 + 50 * std::sin(70 * u + 1) * std::cos(60 * v) + 40 * std::sin(35 * (u + v));
      image.at(x, y)[0] = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
    }
  return image;
}

struct Clip {
  std::vector<Image8> images;
  std::vector<TorsoFrame> frames;
};

Clip make_clip(const std::vector<Vec3d>& motions) {  // dx, dy, roll
  Clip clip;
  for (const Vec3d& m : motions) clip.images.push_back(board(m.x(), m.y(), m.z()));
  for (const Image8& image : clip.images) {
    TorsoFrame f;
    f.grey = &image;
    f.usable = true;
    f.intrinsics = view();
    f.world_from_head = facing_pose(0, 0, {0, -0.1, 0.7});
    clip.frames.push_back(f);
  }
  return clip;
}

const Vec3d kChin(0, -0.08, 0.09);

TEST(Torso, FollowsAShiftInThePicture) {
  std::vector<Vec3d> motions;
  for (int i = 0; i < 12; ++i) motions.push_back({0.0015 * i, -0.001 * i, 0});
  const Clip clip = make_clip(motions);
  const auto track = track_torso(clip.frames, kChin, {}, {});
  ASSERT_TRUE(track.ok());
  ASSERT_TRUE(track->has_torso);
  const Vec3d chest(0.05, -0.2, 0.04);
  const auto place = [&](int i) { return Vec3d(track->world_from_torso[i] * chest); };
  for (int i : {4, 9}) {
    const Vec3d moved = place(i) - place(2);
    EXPECT_NEAR(moved.x(), 0.0015 * (i - 2), 0.0012);
    EXPECT_NEAR(moved.y(), -0.001 * (i - 2), 0.0012);
  }
  EXPECT_LT(track->residual_after, 0.5 * track->residual_before);
}

TEST(Torso, FollowsARollInThePicture) {
  std::vector<Vec3d> motions;
  for (int i = 0; i < 12; ++i) motions.push_back({0, 0, 0.006 * i});
  const Clip clip = make_clip(motions);
  const auto track = track_torso(clip.frames, kChin, {}, {});
  ASSERT_TRUE(track.ok());
  const Mat3d off = track->world_from_torso[9].linear() * track->world_from_torso[2].linear().transpose();
  EXPECT_NEAR(vector_from_turn(off).z(), 0.042, 0.012);
}

TEST(Torso, RestsWhereThePictureShowsNone) {
  Clip clip = make_clip({{0, 0, 0}, {0, 0, 0}});
  for (TorsoFrame& f : clip.frames)
    f.world_from_head = facing_pose(0, 0, {0, 0.15, 0.7});  // the chin at the lower edge
  const auto track = track_torso(clip.frames, kChin, {}, {});
  ASSERT_TRUE(track.ok());
  EXPECT_FALSE(track->has_torso);
  EXPECT_EQ(track->world_from_torso.size(), 2u);
}

}  // namespace
}  // namespace likeness
