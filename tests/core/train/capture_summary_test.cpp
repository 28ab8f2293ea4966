// Claims about the summary of a training set.
#include "core/train/capture_summary.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

TEST(CaptureSummary, OneWildFrameChangesNeitherNeutralNorTypicalView) {
  TrainingSet set = ball_set(31, 16);
  const Articulation before = typical_articulation(set);
  set.views[4].pose.articulation.expression[0] = 50;
  set.views[4].pose.world_from_head.translate(Vec3d(3, 0, 0));
  EXPECT_NEAR(typical_articulation(set).expression[0], before.expression[0], 0.2);
  EXPECT_NE(typical_view(set), 4u);
}

TEST(CaptureSummary, RangesOfActionsAreThoseOfTheirCoefficients) {
  TrainingSet set = ball_set(101, 16);
  for (std::size_t v = 0; v < set.views.size(); ++v)
    set.views[v].pose.articulation.expression[0] = 0.008f * float(v);
  const auto ranges = action_ranges(set);
  ASSERT_EQ(ranges.size(), 1u);
  EXPECT_EQ(ranges[0].name, "bulge");
  EXPECT_NEAR(ranges[0].low, 0.016, 0.01);
  EXPECT_NEAR(ranges[0].high, 0.784, 0.01);
}

TEST(CaptureSummary, CoverageIsTheShareOfFramesBeyondAFifth) {
  TrainingSet set = ball_set(101, 16);
  for (std::size_t v = 0; v < set.views.size(); ++v)
    set.views[v].pose.articulation.expression[0] = v < 25 ? 0.9f : 0.05f;
  const ActionRange range = action_ranges(set).at(0);
  EXPECT_NEAR(range.coverage, 25 / 101.0, 1e-3);
  EXPECT_NEAR(range.histogram.front(), 76 / 101.0, 1e-3);
  EXPECT_NEAR(range.histogram.back(), 25 / 101.0, 1e-3);
  EXPECT_NEAR(std::accumulate(range.histogram.begin(), range.histogram.end(), 0.0f), 1, 1e-4);
}

TEST(CaptureSummary, ACalibratedNeutralIsTheNeutral) {
  TrainingSet set = ball_set(31, 16);
  set.neutral = neutral_articulation(set.model);
  set.neutral.expression.setConstant(0.37f);
  EXPECT_EQ(typical_articulation(set).expression, set.neutral.expression);
}

}  // namespace
}  // namespace likeness
