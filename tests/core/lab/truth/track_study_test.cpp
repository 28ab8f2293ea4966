// Claims about the tracker's steps as a study switches them.
#include "core/lab/truth/track_study.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

TEST(TrackSteps, EachStepHasWhatTheStepsBeforeItHave) {
  const auto steps = track_steps({}, {});
  ASSERT_TRUE(steps.ok());
  ASSERT_EQ(steps->size(), track_step_names().size());
  EXPECT_FALSE((*steps)[0].options.dense);
  EXPECT_FALSE((*steps)[1].options.photometric);
  EXPECT_FALSE((*steps)[2].options.own_shape);
  EXPECT_TRUE(steps->back().options.own_shape);
  for (std::size_t i = 1; i < steps->size(); ++i) EXPECT_TRUE((*steps)[i].options.dense);
  for (std::size_t i = 2; i < steps->size(); ++i) EXPECT_TRUE((*steps)[i].options.photometric);
}

TEST(TrackSteps, AnUnknownStepIsRefusedAndTheKnownOnesNamed) {
  const auto steps = track_steps({"landmarks", "magic"}, {});
  ASSERT_FALSE(steps.ok());
  EXPECT_NE(steps.error().what.find("magic"), std::string::npos);
  EXPECT_NE(steps.error().fix.find("dense"), std::string::npos);
}

}  // namespace
}  // namespace likeness
