// Claims about jobs: they end as their work ended, stop when asked, and guess no time too early.
#include "ui/studio/job.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

namespace likeness::ui {
namespace {

JobStatus wait_for_end(const Job& job) {
  while (is_working(job.status())) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  return job.status();
}

TEST(Job, EndsAsItsWorkEnded) {
  std::atomic<int> wakes = 0;
  const auto wake = [&] { ++wakes; };
  const Job done(
      [](const Progress& p, std::stop_token) -> Result<std::string> {
        p.report(0.5, "half");
        return std::string("written");
      },
      wake);
  EXPECT_EQ(wait_for_end(done).state, JobState::done);
  EXPECT_EQ(done.status().outcome, "written");
  EXPECT_EQ(done.status().text, "half");
  EXPECT_GT(wakes, 0);
  const Job failed(
      [](const Progress&, std::stop_token) -> Result<std::string> {
        return Error{ErrorCode::io, "what", "fix", ""};
      },
      wake);
  EXPECT_EQ(wait_for_end(failed).state, JobState::failed);
  EXPECT_EQ(failed.status().error->fix, "fix");
  const Job thrown(
      [](const Progress&, std::stop_token) -> Result<std::string> { throw std::runtime_error("thrown"); },
      wake);
  EXPECT_EQ(wait_for_end(thrown).state, JobState::failed);
  EXPECT_FALSE(thrown.status().error->fix.empty());
}

TEST(Job, StopsWhenAskedAndWhenItGoes) {
  const auto until_stopped = [](const Progress&, std::stop_token stop) -> Result<std::string> {
    while (!stop.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return cancelled_error();
  };
  Job job(until_stopped, [] {});
  job.stop();
  EXPECT_EQ(wait_for_end(job).state, JobState::stopped);
  const Job other(until_stopped, [] {});  // its destructor must not hang
}

TEST(Job, APauseHoldsTheWorkUntilItGoesOnOrIsStopped) {
  std::atomic<int> reports = 0;
  const auto counts = [&](const Progress& progress, std::stop_token stop) -> Result<std::string> {
    while (!stop.stop_requested()) {
      progress.report(0.5, "counting");
      ++reports;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return cancelled_error();
  };
  Job job(counts, [] {});
  const auto until = [&](auto so) {
    while (!so()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  until([&] { return reports > 3; });
  job.pause();
  until([&] { return job.status().waiting; });
  const int held = reports;
  const double worked = job.status().seconds;
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  EXPECT_EQ(reports, held);
  EXPECT_TRUE(is_working(job.status()));
  EXPECT_TRUE(job.status().paused);
  EXPECT_NEAR(job.status().seconds, worked, 1e-9);  // a pause is no work
  job.go_on();
  until([&] { return reports > held + 3; });
  EXPECT_FALSE(job.status().paused);
  EXPECT_FALSE(job.status().waiting);
  job.pause();
  until([&] { return job.status().waiting; });
  job.stop();
  EXPECT_EQ(wait_for_end(job).state, JobState::stopped);
  EXPECT_FALSE(job.status().paused);
}

TEST(EstimateLeft, SaysNothingBeforeTheRateIsKnown) {
  EXPECT_LT(estimate_left(0, 0.5, 1, 1), 0);
  EXPECT_LT(estimate_left(0, 0.01, 1, 60), 0);
  EXPECT_DOUBLE_EQ(estimate_left(0, 0.25, 1, 10), 30);
  EXPECT_DOUBLE_EQ(estimate_left(0.5, 0.6, 0.7, 10), 10);
  EXPECT_LT(estimate_left(0.5, 0.5, 0.5, 10), 0);
}

}  // namespace
}  // namespace likeness::ui
