// The window used without end: a project opened, directed, exported, trained longer and closed, cycle after
// cycle, by injected hands. What it holds at the end of a cycle must not grow.
#include <gtest/gtest.h>
#include <malloc.h>

#include <cmath>
#include <cstdio>
#include <iterator>
#include <vector>

#include "tests/support/trials.h"
#include "tests/ui/driven_studio.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;

// The slope of a line through (0, y0), (1, y1), ... and its standard error.
struct Growth {
  double slope = 0, error = 0;
};
Growth growth_of(const std::vector<double>& y) {
  const double n = double(y.size()), middle = (n - 1) / 2;
  double mean = 0, across = 0, along = 0, rest = 0;
  for (const double v : y) mean += v / n;
  for (std::size_t i = 0; i < y.size(); ++i) {
    across += (double(i) - middle) * (y[i] - mean);
    along += (double(i) - middle) * (double(i) - middle);
  }
  const double slope = across / along;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double off = y[i] - mean - slope * (double(i) - middle);
    rest += off * off;
  }
  return {slope, std::sqrt(rest / (n - 2) / along)};
}

// Entries of a folder of /proc that counts something of this process.
double count_in(const char* folder) {
  return double(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

class StudioSoak : public test::DrivenStudio {
 protected:
  void SetUp() override {
    DrivenStudio::SetUp();
    options_.project.train.steps = 5;
    options_.longer_s = 1;
    start();
  }

  void wait_for(double seconds, const std::function<bool(const Snapshot&)>& so, const char* what) {
    ASSERT_TRUE(until(seconds, so)) << what << ": "
                                    << studio_->snapshot().project.pipeline.job.error.value_or(Error{}).what;
  }
  static bool rested(const Snapshot& s) {
    return s.direct.picture && s.direct.picture->last && !s.direct.rendering;
  }

  void cycle() {
    click("recent demo.likeness");
    ASSERT_NO_FATAL_FAILURE(wait_for(
        60, [](const Snapshot& s) { return s.project.contents && s.project.contents->avatar; }, "opening"));
    click("step Direct");
    ASSERT_NO_FATAL_FAILURE(wait_for(120, rested, "the first picture"));
    test::drag("##head yaw", 30, 0, 0, [this] { frame(); });
    ASSERT_NO_FATAL_FAILURE(wait_for(120, rested, "a turned head"));
    click("Undo");
    click("step Export");
    click("Export a still");
    ASSERT_NO_FATAL_FAILURE(wait_for(
        120, [](const Snapshot& s) { return !s.exports.written.empty(); }, "the still"));
    click("step Train");
    click("Train longer");
    ASSERT_NO_FATAL_FAILURE(wait_for(
        600, [](const Snapshot& s) { return !is_working(s.project.pipeline.job) && s.situation.finished; },
        "training longer"));
    click("menu File");
    click("item Close the project");
    ASSERT_NO_FATAL_FAILURE(wait_for(
        60, [](const Snapshot& s) { return s.project.contents == nullptr; }, "closing"));
  }
};

TEST_F(StudioSoak, WhatItHoldsDoesNotGrow) {
  click("Try the demo");
  ASSERT_NO_FATAL_FAILURE(wait_for(
      300, [](const Snapshot& s) { return s.project.contents != nullptr; }, "the demo"));
  click("Make the avatar");
  ASSERT_NO_FATAL_FAILURE(wait_for(
      900, [](const Snapshot& s) { return s.situation.finished && s.project.contents->avatar; },
      "the avatar"));
  click("menu File");
  click("item Close the project");
  std::vector<double> bytes, files, threads;
  likeness::test::run_trials("soak of the window", [&](std::uint64_t) {
    ASSERT_NO_FATAL_FAILURE(cycle());
    const auto memory = ::mallinfo2();
    bytes.push_back(double(memory.uordblks + memory.hblkhd));
    files.push_back(count_in("/proc/self/fd"));
    threads.push_back(count_in("/proc/self/task"));
  });
  ASSERT_FALSE(HasFatalFailure());
  // The first cycles fill what is kept once.
  const std::size_t warm = std::min<std::size_t>(5, bytes.size() / 2);
  for (auto* row : {&bytes, &files, &threads}) row->erase(row->begin(), row->begin() + std::ptrdiff_t(warm));
  if (bytes.size() < 5) GTEST_SKIP() << bytes.size() << " cycles after the first " << warm << " tell nothing";
  for (const auto& [what, row, least] :
       {std::tuple("bytes", &bytes, 4096.0), {"open files", &files, 0.01}, {"threads", &threads, 0.01}}) {
    const Growth growth = growth_of(*row);
    std::printf("soak: %s %.0f -> %.0f over %zu cycles, %+.3f +- %.3f a cycle\n", what, row->front(),
                row->back(), row->size(), growth.slope, growth.error);
    // Three errors above nothing, and more than could be noise of the measure.
    EXPECT_FALSE(growth.slope > 3 * growth.error && growth.slope > least) << what << " grow";
  }
}

}  // namespace
}  // namespace likeness::ui
