// Claims about what is held out.
#include "core/capture/hold_out.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

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

TEST(HoldOutSides, TrainsNearHoldsOutFarAndKeepsTheRestApart) {
  auto frames = frames_of(100);
  for (int i = 0; i < 100; ++i) frames[std::size_t(i)].view = {0.4 * (i - 50), 0};  // -20 to 19.6 degrees
  frames[50].view.reset();
  frames[60].view = {0, -17};    // looks down
  frames[61].view = {9, 9};      // neither angle alone is that far: 12.7 degrees together
  hold_out_random(frames, 0.3);  // an earlier choice leaves nothing behind
  frames[50].apart = true, frames[51].apart = true;
  hold_out_sides(frames, {10, 16}, 0.1);
  for (const CaptureFrame& frame : frames) {
    const double off = frame.view ? angle_deg(*frame.view) : 0;
    const bool inside = frame.view && off <= 10, beyond = frame.view && off > 16;
    EXPECT_EQ(frame.apart, !inside && !beyond) << frame.frame;
    EXPECT_EQ(frame.refused.empty(), !frame.apart) << frame.frame;
    if (beyond) {
      EXPECT_TRUE(frame.held_out) << frame.frame;
    }
    EXPECT_FALSE(frame.apart && frame.held_out);
  }
  EXPECT_TRUE(frames[60].held_out);
  EXPECT_TRUE(frames[61].apart);
  EXPECT_NE(frames[61].refused.find("between"), std::string::npos);
  EXPECT_TRUE(frames[50].apart);
  EXPECT_NE(frames[50].refused.find("not known"), std::string::npos);
}

TEST(HoldOutSides, OfThoseInsideTheLastTenthIsHeldOutInTheOrderOfTheClip) {
  auto frames = frames_of(200);
  for (std::size_t i = 0; i < 200; ++i)
    frames[i].view = {i % 2 ? 3.0 : i % 4 ? 15.0 : -30.0, 1};  // the head swings to and fro
  hold_out_sides(frames, {}, 0.1);
  int inside = 0, beyond = 0, apart = 0;
  for (const CaptureFrame& frame : frames) {
    const double off = angle_deg(*frame.view);
    beyond += frame.held_out && off > 20, apart += frame.apart;
    if (!frame.held_out || off > 10) continue;
    ++inside;
    EXPECT_GE(frame.frame, 2 * 180);
  }
  EXPECT_EQ(inside, 10);
  EXPECT_EQ(beyond, 50);
  EXPECT_EQ(apart, 50);
  auto again = frames;
  hold_out_sides(again, {}, 0.1);
  EXPECT_EQ(held_out(again), held_out(frames));
  hold_out_sides(again, {}, 0);
  EXPECT_EQ(held_out(again).size(), 50u);
}

}  // namespace
}  // namespace likeness
