// Claims about torsos that rest while the camera is walked round them.
#include "core/track/torso/torso_rest.h"

#include <gtest/gtest.h>

#include "tests/core/track/torso/torso_board.h"

namespace likeness {
namespace {

// A camera that walks `way` metres to the side in the first `walk` frames, then stands; a head that sways.
std::vector<TorsoFrame> walk_then_stand(int walk, int count, double way, double sway) {
  std::vector<TorsoFrame> frames(std::size_t(count), TorsoFrame{});
  for (int i = 0; i < count; ++i) {
    TorsoFrame& f = frames[std::size_t(i)];
    f.usable = true;
    f.cam_from_world.translation().x() = -way * std::min(i, walk) / walk;
    f.world_from_head = facing_pose(0, 0, {sway * std::sin(1.3 * i), 0, 0.7});
  }
  return frames;
}

int in_stretch(const std::vector<int>& stretches, int number) {
  return int(std::ranges::count(stretches, number));
}

TEST(RestingTorso, IsFoundForAStillHeadBeforeAWalkingCamera) {
  const auto still = resting_torso(walk_then_stand(20, 30, 0.4, 0.002));
  EXPECT_EQ(in_stretch(still, 0), 20);
  for (std::size_t i = 0; i < 30; ++i) EXPECT_EQ(still[i], i < 20 ? 0 : -1) << i;
  EXPECT_EQ(in_stretch(resting_torso(walk_then_stand(20, 30, 0.4, 0.05)), -1), 30);    // the head moves, too
  EXPECT_EQ(in_stretch(resting_torso(walk_then_stand(20, 30, 0.03, 0.002)), -1), 30);  // hardly a walk
  EXPECT_EQ(in_stretch(resting_torso(walk_then_stand(5, 30, 0.4, 0.002)), -1), 30);    // too few to tell
  EXPECT_EQ(in_stretch(resting_torso({}), 0), 0);
}

TEST(RestingTorso, ALostFrameDoesNotEndAStretchAndAHeldOutOneDoesNotDecide) {
  auto frames = walk_then_stand(20, 30, 0.4, 0.002);
  frames[7].usable = false;
  for (const std::size_t i : {9u, 10u, 11u, 12u}) frames[i].held_out = true;
  for (const std::size_t i : {10u, 11u}) frames[i].world_from_head.translation().x() += 0.3;
  const auto stretches = resting_torso(frames);
  EXPECT_EQ(in_stretch(stretches, 0), 17);
  EXPECT_EQ(stretches[7], -1);
  EXPECT_EQ(stretches[9], 0);
  EXPECT_EQ(stretches[10], -1);  // its own head plainly moves
}

// The template's depth is a guess. Pictures of a board that rests, but elsewhere in depth than is guessed:
// its shift in the picture, as the camera moves sideways, is only apparent.
TEST(RestingTorso, SharesOnePlaceWhileTheCameraWalksAndIsFollowedAfterwards) {
  constexpr int kWalk = 16, kCount = 44;
  const double way = 0.16, nearer = 1.25;
  std::vector<Image8> images;
  for (int i = 0; i < kCount; ++i) {
    const double aside = way * std::min(i, kWalk) / kWalk;
    images.push_back(board(-nearer * aside + (i > kWalk ? shift_of(i) : 0), 0, 0));
  }
  BoardClip clip = show(std::move(images));
  for (int i = 0; i < kCount; ++i) {
    TorsoFrame& f = clip.frames[std::size_t(i)];
    f.cam_from_world.translation().x() = -way * std::min(i, kWalk) / kWalk;
    f.held_out = i == 5 || i == 6 || i > 40;
  }
  const auto track = track_torso(clip.frames, kChin, {}, {});
  ASSERT_TRUE(track.ok());
  EXPECT_GE(track->reference, kWalk);  // learnt from the frames in which it moves
  const auto& poses = track->world_from_torso;
  for (std::size_t i = 1; i < kWalk; ++i) {
    EXPECT_EQ(poses[i].matrix(), poses[0].matrix()) << i;
    EXPECT_EQ(track->shapes[i], track->shapes[0]) << i;
  }
  // It is where the walk left it.
  EXPECT_NEAR(poses[0].translation().x(), poses[kWalk].translation().x(), 0.015);
  for (const int i : {20, 30, 42})
    EXPECT_NEAR(poses[std::size_t(i)].translation().x() - poses[kWalk].translation().x(), shift_of(i), 0.0025)
        << i;
}

}  // namespace
}  // namespace likeness
