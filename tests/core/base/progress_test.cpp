// Claims about progress.
#include "core/base/progress.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>
#include <vector>

namespace likeness {
namespace {

TEST(Progress, StagesMapIntoTheirPartOfTheWhole) {
  ProgressReport last;
  const Progress root([&](const ProgressReport& report) { last = report; });
  const Progress stage = root.stage(0.5, 1.0, "train").stage(0.0, 0.5, "warm");
  stage.report(0.5, "half");
  EXPECT_DOUBLE_EQ(last.fraction, 0.625);
  EXPECT_EQ(last.stage, "warm");
  EXPECT_EQ(last.text, "half");
}

TEST(Progress, NeverFallsAndNeverPassesOne) {
  std::vector<double> seen;
  const Progress root([&](const ProgressReport& report) { seen.push_back(report.fraction); });
  for (const double f : {0.2, 0.1, -3.0, 0.7, 9.0, 0.3}) root.report(f);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_DOUBLE_EQ(seen.back(), 1.0);
}

TEST(Progress, CountsReportsFromManyThreads) {
  int reports = 0;
  const Progress root([&](const ProgressReport&) { ++reports; });
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([root] {
        for (int i = 0; i < 1000; ++i) root.report(i / 1000.0);
      });
    }
  }
  EXPECT_EQ(reports, 4000);
}

TEST(Progress, WithoutAListenerDoesNothing) { Progress().stage(0, 1, "x").report(0.5); }

// Standard error may be closed or full.
TEST(Progress, ASinkThatFailsDoesNotEndTheWork) {
  const Progress progress([](const ProgressReport&) { throw std::runtime_error("no space left"); });
  EXPECT_NO_THROW(progress.report(0.5, "half"));
  EXPECT_NO_THROW(progress.report(1));
}

}  // namespace
}  // namespace likeness
