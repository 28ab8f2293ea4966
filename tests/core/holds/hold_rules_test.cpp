// Claims about verdicts: the worst figure decides, the way outwards ends where the first try fails.
#include "core/holds/hold_rules.h"

#include <gtest/gtest.h>

#include <set>

namespace likeness {
namespace {

HoldFigures with(HoldFault fault, double limits) {
  HoldFigures figures;
  figures[fault] = limits * hold_rule(fault).limit;
  return figures;
}

TEST(HoldRules, EachHasANameAndWordsOfItsOwn) {
  std::set<std::string_view> names, words;
  for (int f = 0; f < kHoldFaults; ++f) {
    const HoldRule& rule = hold_rule(HoldFault(f));
    names.insert(rule.name), words.insert(rule.words);
    EXPECT_GT(rule.limit, 0) << rule.name;
    EXPECT_EQ(find_hold_rule(rule.name), &rule);
  }
  EXPECT_EQ(names.size(), std::size_t(kHoldFaults));
  EXPECT_EQ(words.size(), std::size_t(kHoldFaults));
  EXPECT_EQ(find_hold_rule("of a later version"), nullptr);
}

TEST(HoldScore, IsTheWorstFigureInItsLimit) {
  HoldFigures figures = with(HoldFault::drift, 0.5);
  figures[HoldFault::loose] = 2 * hold_rule(HoldFault::loose).limit;
  figures[HoldFault::specks] = -hold_rule(HoldFault::specks).limit;  // fewer than where it was filmed
  EXPECT_DOUBLE_EQ(hold_score(figures).score, 2);
  EXPECT_EQ(hold_score(figures).fault, HoldFault::loose);
  EXPECT_EQ(hold_score({}).fault, std::nullopt);
  EXPECT_EQ(hold_score({}).score, 0);
  EXPECT_EQ(hold_score(with(HoldFault::specks, -1)).score, 0);
}

TEST(HoldEnd, LiesBetweenTheLastThatHoldsAndTheFirstThatFails) {
  const std::vector<HoldStep> steps{{10, with(HoldFault::drift, 0.5)},
                                    {20, with(HoldFault::loose, 1.5)},
                                    {30, with(HoldFault::drift, 0.1)}};  // too late
  const HeldEnd end = hold_end(-2, steps);
  EXPECT_DOUBLE_EQ(end.deg, 15);
  EXPECT_EQ(end.fault, "loose");
  const HeldEnd all = hold_end(-2, std::span(steps).first(1));
  EXPECT_DOUBLE_EQ(all.deg, 10);
  EXPECT_EQ(all.fault, "");
  EXPECT_DOUBLE_EQ(hold_end(-2, {}).deg, -2);
  // Downwards as upwards; the first try of all may fail.
  const std::vector<HoldStep> down{{-12, with(HoldFault::drift, 2)}};
  EXPECT_DOUBLE_EQ(hold_end(-2, down).deg, -7);
}

TEST(HoldsView, AsksBothAxes) {
  HoldingRange range;
  range.yaw_low.deg = -20, range.yaw_high.deg = 30, range.pitch_low.deg = -5, range.pitch_high.deg = 10;
  EXPECT_TRUE(holds_view(range, -20, 10));
  EXPECT_FALSE(holds_view(range, -22, 0));
  EXPECT_FALSE(holds_view(range, 0, 12));
}

TEST(HoldsAction, WhatWasNotTriedIsNotDenied) {
  HoldingRange range;
  range.actions = {{"jawOpen", 0.6f, "mouth"}};
  EXPECT_TRUE(holds_action(range, "jawOpen", 0.6f));
  EXPECT_FALSE(holds_action(range, "jawOpen", 0.7f));
  EXPECT_TRUE(holds_action(range, "cheekPuff", 1));
}

}  // namespace
}  // namespace likeness
