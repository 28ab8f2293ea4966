// Claims about what is held out.
#include "core/capture/hold_out.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace likeness {
namespace {

std::vector<CaptureFrame> frames_of(int count) {
  std::vector<CaptureFrame> frames;
  for (int i = 0; i < count; ++i)
    frames.push_back({2 * i, i / 25.0, 100, false, false, ""});  // every other one
  return frames;
}

std::vector<int> held_out(const std::vector<CaptureFrame>& frames) {
  std::vector<int> numbers;
  for (const CaptureFrame& frame : frames)
    if (frame.held_out) numbers.push_back(frame.frame);
  return numbers;
}

TEST(HoldOutTail, TakesTheLastTenthOfAllFrames) {
  auto frames = frames_of(400);
  hold_out_tail(frames, 0.1);
  for (int i = 0; i < 400; ++i) EXPECT_EQ(frames[std::size_t(i)].held_out, i >= 360) << i;
}

TEST(HoldOutTail, TakesAtLeastOneAndNoneOnlyWhenAskedForNone) {
  auto frames = frames_of(3);
  hold_out_tail(frames, 0.1);
  EXPECT_TRUE(frames.back().held_out);
  hold_out_tail(frames, 0);
  EXPECT_FALSE(frames.back().held_out);
}

TEST(HoldOutViews, TakesATenthOfTheMovingFramesInARowBetweenOthersThatTrain) {
  auto frames = frames_of(240);
  hold_out_tail(frames, 0.1);              // an earlier choice leaves nothing behind
  hold_out_views(frames, {20, 180}, 0.1);  // 81 frames move
  const std::vector<int> held = held_out(frames);
  ASSERT_EQ(held.size(), 8u);
  for (std::size_t i = 1; i < held.size(); ++i) EXPECT_EQ(held[i], held[i - 1] + 2);
  EXPECT_NEAR(0.5 * (held.front() + held.back()), 100, 2);
}

TEST(HoldOutRandom, TakesAsManyAsAskedSpreadOverTheClipAndAlwaysTheSame) {
  auto frames = frames_of(300), again = frames_of(300);
  hold_out_random(frames, 0.3);
  hold_out_random(again, 0.3);
  const std::vector<int> held = held_out(frames);
  EXPECT_EQ(held.size(), 90u);
  EXPECT_EQ(held, held_out(again));
  for (int part = 0; part < 3; ++part) {
    const auto inside = std::ranges::count_if(held, [&](int f) { return f / 200 == part; });
    EXPECT_GT(inside, 15) << part;
    EXPECT_LT(inside, 45) << part;
  }
}

}  // namespace
}  // namespace likeness
