// Claims about the ranges of angles that a study of sides puts held-out frames into.
#include "core/lab/beyond/sides_study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace likeness {
namespace {

// Frames seen from all over the front, split at 10 and 20 degrees.
std::vector<CaptureFrame> all_over() {
  std::vector<CaptureFrame> frames;
  for (int yaw = -42; yaw <= 42; yaw += 3)
    for (int pitch = -27; pitch <= 27; pitch += 3) {
      CaptureFrame& frame = frames.emplace_back();
      frame.frame = int(frames.size());
      frame.view = {double(yaw), double(pitch)};
      const double off = angle_deg(*frame.view);
      frame.held_out = off > 20 || (off <= 10 && yaw == 3);
      frame.used = off <= 10 && !frame.held_out, frame.apart = !frame.held_out && !frame.used;
    }
  return frames;
}

TEST(SidesRows, EveryFrameBeyondLiesInOneRowOfEachKindAndNoOtherFrameDoes) {
  const std::vector<CaptureFrame> frames = all_over();
  for (const bool by_direction : {false, true}) {
    const std::vector<SidesRow> rows = sides_rows(frames, {}, by_direction);
    for (const CaptureFrame& frame : frames) {
      const auto in = std::ranges::count_if(
          rows, [&](const SidesRow& row) { return is_in_row(row, frame, SideRange{}); });
      EXPECT_EQ(in, frame.held_out && angle_deg(*frame.view) > 20 ? 1 : 0) << frame.frame;
    }
    for (const SidesRow& row : rows) {
      EXPECT_EQ(row.to_deg, row.from_deg + 10);
      EXPECT_EQ(row.angle == SidesAngle::off, !by_direction);
      EXPECT_TRUE(std::ranges::any_of(
          frames, [&](const CaptureFrame& frame) { return is_in_row(row, frame, SideRange{}); }));
    }
  }
}

TEST(SidesRows, LieInOrderWithTheMeanOfTheirFrames) {
  const std::vector<SidesRow> rows = sides_rows(all_over(), {}, true);
  ASSERT_GE(rows.size(), 6u);
  EXPECT_EQ(rows.front().angle, SidesAngle::yaw);
  EXPECT_EQ(rows.front().from_deg, -50);
  EXPECT_EQ(rows.back().angle, SidesAngle::pitch);
  EXPECT_EQ(rows.back().to_deg, 30);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    EXPECT_LE(rows[i - 1].angle, rows[i].angle);
    if (rows[i - 1].angle == rows[i].angle) {
      EXPECT_LT(rows[i - 1].from_deg, rows[i].from_deg);
    }
  }
  const auto left = std::ranges::find_if(
      rows, [](const SidesRow& row) { return row.angle == SidesAngle::yaw && row.from_deg == 30; });
  ASSERT_NE(left, rows.end());
  EXPECT_NEAR(left->yaw_deg, 34.5, 1.6);  // of 30, 33, 36 and 39 degrees
  EXPECT_NEAR(left->pitch_deg, 0, 1e-9);
}

}  // namespace
}  // namespace likeness
