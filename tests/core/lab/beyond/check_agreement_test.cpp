// Claims about verdicts beside the truth: limits grow with the angle, and what is wrong is counted.
#include "core/lab/beyond/check_agreement.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

BeyondView view_of(double yaw, double psnr_head_db) {
  BeyondView view;
  view.yaw = yaw, view.iou = 1;
  view.score.psnr_head_db = psnr_head_db;
  return view;
}

HoldFigures drifting(double levels) {
  HoldFigures figures;
  figures[HoldFault::drift] = levels;
  return figures;
}

BeyondStudy small_study() {
  BeyondStudy study;
  study.inside.psnr_head_db = 30, study.inside.psnr_face_db = 30;
  study.views = {view_of(0, 31), view_of(15, 28.5), view_of(30, 25.5), view_of(-15, 27)};
  const double limit = hold_rule(HoldFault::drift).limit;
  study.holds.views = {
      {15, 0, drifting(0.5 * limit)}, {30, 0, drifting(0.8 * limit)}, {-15, 0, drifting(0.9 * limit)}};
  study.holds.range.yaw_high.deg = 30, study.holds.range.yaw_low.deg = -15;
  BeyondAction jaw;
  jaw.name = "jawOpen", jaw.amount = 1;
  jaw.score.psnr_face_db = 29, jaw.forehead_change = 2;
  study.actions = {jaw};
  study.holds.actions = {{{"jawOpen", {"jawOpen"}, 1}, drifting(3 * limit)}};
  study.holds.range.actions = {{"jawOpen", 0.3f, "drift"}};
  return study;
}

TEST(CheckedCases, ALossOfTwoDecibelsIsAllowedForEvery15Degrees) {
  const auto cases = checked_cases(small_study());
  ASSERT_EQ(cases.size(), 4u);  // the front is none
  EXPECT_EQ(cases[0].name, "yaw +15");
  EXPECT_DOUBLE_EQ(cases[0].truth, 0.75);
  EXPECT_TRUE(cases[0].truth_holds && cases[0].check_holds);
  EXPECT_DOUBLE_EQ(cases[1].truth, 4.5 / 4);
  EXPECT_FALSE(cases[1].truth_holds);
  EXPECT_TRUE(cases[1].check_holds);
  EXPECT_DOUBLE_EQ(cases[2].truth, 1.5);
  EXPECT_EQ(cases[2].truth_fault, "psnr_head");
  EXPECT_EQ(cases[3].truth_fault, "forehead");
  EXPECT_FALSE(cases[3].truth_holds || cases[3].check_holds);
  EXPECT_EQ(cases[3].check_fault, "drift");
}

TEST(CheckAgreement, CountsWhatIsWrongAndRanksTheRest) {
  const CheckAgreement agreement = check_agreement(checked_cases(small_study()));
  EXPECT_EQ(agreement.cases, 4);
  EXPECT_EQ(agreement.wrong, 2);
  EXPECT_EQ(agreement.held, 1);
  EXPECT_EQ(agreement.held_found, 1);
  EXPECT_EQ(agreement.claimed, 3);
  EXPECT_EQ(agreement.claimed_wrong, 2);
  ASSERT_TRUE(agreement.rank_views);
  EXPECT_DOUBLE_EQ(*agreement.rank_views, 1);
  EXPECT_FALSE(agreement.rank_actions) << "of one action there is no rank";
}

}  // namespace
}  // namespace likeness
