// Claims about the schedule: a budgeted run can be replayed by its number of steps.
#include "core/train/schedule.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace likeness {
namespace {

TEST(LearningRate, RisesStaysAndFallsToItsEnd) {
  const Schedule schedule{1000};
  EXPECT_LT(learning_rate(0, schedule), 0.2);
  EXPECT_DOUBLE_EQ(learning_rate(200, schedule), 1.0);
  for (std::uint64_t s = 350; s < 1000; ++s)
    EXPECT_GE(learning_rate(s, schedule), learning_rate(s + 1, schedule));
  EXPECT_NEAR(learning_rate(1000, schedule), kFinalRate, 1e-12);
}

TEST(Settle, ARunByBudgetHasTheSameRatesAsItsReplayBySteps) {
  Schedule budgeted;
  budgeted.budget_s = 10;
  HalfWay half_way;
  std::vector<double> rates;
  for (std::uint64_t step = 0; budgeted.total_steps == 0 || step < budgeted.total_steps; ++step) {
    rates.push_back(learning_rate(step, budgeted));
    settle(budgeted, half_way, step + 1, 0.05 * double(step + 1), 0.05);
  }
  EXPECT_NEAR(double(rates.size()), 200, 3);
  const Schedule replay{rates.size()};
  for (std::uint64_t step = 0; step < rates.size(); ++step)
    EXPECT_EQ(rates[step], learning_rate(step, replay)) << step;
}

TEST(Settle, HoldsEvenWhenStepsBecomeSlower) {
  Schedule budgeted;
  budgeted.budget_s = 10;
  HalfWay half_way;
  // 100 quick steps, then one a second: 107 in all would be too few.
  settle(budgeted, half_way, 100, 2.9, 1.0);
  EXPECT_LE(100, kFlatShare * double(budgeted.total_steps));
}

TEST(Settle, UsesMoreThanTheMomentaryPace) {
  Schedule budgeted;
  budgeted.budget_s = 600;
  HalfWay half_way;
  double seconds = 0;
  std::uint64_t step = 0;
  while (budgeted.total_steps == 0) {  // three quick steps, three slow ones, 0.13 s in the mean
    const double taken = step / 3 % 2 == 0 ? 0.11 : 0.15;
    settle(budgeted, half_way, ++step, seconds += taken, taken);
  }
  EXPECT_NEAR(double(budgeted.total_steps), 600 / 0.13, 10);
}

TEST(Settle, WorksForAResumedRun) {
  Schedule budgeted;
  budgeted.budget_s = 100;
  HalfWay half_way;
  settle(budgeted, half_way, 270, 27, 0.5);
  EXPECT_EQ(budgeted.total_steps, 0u);
  settle(budgeted, half_way, 281, 28.1, 0.5);  // eleven steps are more reliable than the last ones' mean
  EXPECT_NEAR(double(budgeted.total_steps), 1000, 2);
  for (const double before : {27.95, 40.0}) {  // hardly a step before it is due, and none
    Schedule late;
    late.budget_s = 100;
    HalfWay none;
    settle(late, none, 280, before, 0.1);
    settle(late, none, 281, std::max(28.1, before), 0.1);
    EXPECT_NEAR(double(late.total_steps), before < 28 ? 1000 : 880, 2) << before;
  }
}

TEST(IsOver, AtThePlannedStepsOrASeventhBeyondTheBudget) {
  EXPECT_FALSE(is_over({.total_steps = 0, .budget_s = 10}, 50, 11.4));
  EXPECT_TRUE(is_over({.total_steps = 0, .budget_s = 10}, 50, 11.6));
  EXPECT_TRUE(is_over({.total_steps = 50, .budget_s = 10}, 50, 8));
  EXPECT_FALSE(is_over({.total_steps = 50, .budget_s = 10}, 49, 10.5));
  EXPECT_FALSE(is_over({.total_steps = 50}, 49, 1e9));  // steps were requested
  EXPECT_FALSE(
      is_over({.total_steps = 0, .budget_s = 1}, 0, 20));  // a model without a step would be untrained
}

TEST(ResumeSchedule, RefusesToTurnARunIntoADifferentOne) {
  Schedule done{100};
  EXPECT_FALSE(resume_schedule(done, 100, 5, 150, 0));
  Schedule same{100};
  EXPECT_TRUE(resume_schedule(same, 60, 5, 100, 0));
  Schedule early{100};
  EXPECT_TRUE(resume_schedule(early, 20, 5, 150, 0));
  EXPECT_EQ(early.total_steps, 150u);
  Schedule fallen{100};  // what is due where the rate begins to fall may be done already
  EXPECT_FALSE(resume_schedule(fallen, 35, 5, 150, 0));
}

TEST(ResumeSchedule, ALongerBudgetContinuesAFinishedRun) {
  Schedule done;
  done.total_steps = 100, done.budget_s = 10;
  EXPECT_TRUE(resume_schedule(done, 100, 10, 0, 30));
  EXPECT_NEAR(double(done.total_steps), 300, 1);
}

// 14 s in which the process was stopped are no step's.
TEST(StepSeconds, APauseCountsAsOneStep) {
  StepSeconds steps;
  double sum = 0;
  for (int step = 0; step < 10; ++step) sum += steps.count(step == 5 ? 14.6 : 0.6);
  EXPECT_NEAR(sum, 6, 1e-9);
}

TEST(StepSeconds, SlowStepsThatStayAreCountedBeforeLong) {
  StepSeconds steps;
  for (int step = 0; step < 40; ++step) steps.count(0.1);
  double sum = 0;
  for (int step = 0; step < 40; ++step) sum += steps.count(2);
  EXPECT_GT(sum, 40);
}

}  // namespace
}  // namespace likeness
