// Claims about work clocks: waiting costs no processor time, and work costs every thread's.
#include "core/base/work_clock.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace likeness {
namespace {

TEST(WorkClock, WaitingDoesNotCount) {
  const double wall = clock_seconds(WorkClock::wall), worked = clock_seconds(WorkClock::processor);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const double waited = clock_seconds(WorkClock::wall) - wall;
  EXPECT_GE(waited, 0.2);
  EXPECT_LT(clock_seconds(WorkClock::processor) - worked, 0.5 * waited);
}

TEST(WorkClock, WorkOfAnotherThreadCounts) {
  const double start = clock_seconds(WorkClock::processor);
  std::thread([&] {
    while (clock_seconds(WorkClock::processor) < start + 0.05) {
    }
  }).join();
  EXPECT_GE(clock_seconds(WorkClock::processor) - start, 0.05);
}

}  // namespace
}  // namespace likeness
