// Claims about the strip of a track's errors.
#include "core/track/clip/error_strip.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

Track track_of(int frames) {
  Track track;
  for (int i = 0; i < frames; ++i) {
    TrackedFrame f;
    f.frame = i;
    f.inner_error_px = 1.5;
    f.landmark_spread.fill(1.0);
    track.frames.push_back(f);
  }
  return track;
}

int reddish(const Image8& picture) {
  int count = 0;
  for (std::size_t i = 0; i < picture.data.size(); i += 3)
    count += picture.data[i] > 180 && picture.data[i + 1] < 80 && picture.data[i + 2] < 80;
  return count;
}

TEST(ErrorStrip, LostFramesShowInRedAndOnlyThey) {
  Track track = track_of(100);
  EXPECT_EQ(reddish(error_strip(track)), 0);
  track.frames[50].status = FrameStatus::lost;
  const int one = reddish(error_strip(track));
  EXPECT_GT(one, 20);
  track.frames[51].status = FrameStatus::lost;
  EXPECT_EQ(reddish(error_strip(track)), 2 * one);
}

TEST(ErrorStrip, EveryFrameHasItsColumn) {
  EXPECT_GE(error_strip(track_of(3000)).width, 3000);
  EXPECT_EQ(error_strip(track_of(3000)).height, error_strip(track_of(10)).height);
}

TEST(ErrorStrip, EmptyTrackStillGivesAPicture) { EXPECT_FALSE(error_strip(Track()).empty()); }

TEST(ErrorStrip, SpreadLeavesTheJawLineOut) {
  TrackedFrame f;
  f.landmark_spread.fill(2);
  for (int i = 0; i < 17; ++i) f.landmark_spread[i] = 50;
  EXPECT_DOUBLE_EQ(mean_inner_spread(f), 2);
}

}  // namespace
}  // namespace likeness
