// Claims about threads of low priority: they yield, and no other does.
#include "core/base/priority.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "core/base/parallel.h"

namespace likeness {
namespace {

// Started this way (by nice), its priority cannot be lowered further.
constexpr int kFarBack = 10;

int niceness() { return ::getpriority(PRIO_PROCESS, id_t(::syscall(SYS_gettid))); }

TEST(Priority, BackgroundThreadsAndThoseTheyStartYieldToOthers) {
  const int usual = niceness();
  if (usual >= kFarBack) GTEST_SKIP() << "all of this program was started after others";
  int stepped = usual, started = usual;
  std::thread([&] {
    lower_thread_priority();
    stepped = niceness();
    std::thread([&] { started = niceness(); }).join();
  }).join();
  EXPECT_GT(stepped, usual);
  EXPECT_EQ(started, stepped);
  EXPECT_EQ(niceness(), usual);
}

TEST(Priority, LoopsUseBackgroundThreadsButTheCallerStaysNormal) {
  if (hardware_threads() < 2) GTEST_SKIP() << "one processor: loops borrow no thread";
  const int usual = niceness();
  if (usual >= kFarBack) GTEST_SKIP() << "all of this program was started after others";
  const auto caller = std::this_thread::get_id();
  const LowPriorityLoops back;
  std::atomic<int> lent{0}, forward{0};
  // Long enough for a second thread to join.
  for (int round = 0; round < 200 && lent == 0; ++round)
    parallel_for(64, [&](std::size_t) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (std::this_thread::get_id() == caller) return;
      ++lent;
      forward += niceness() <= usual;
    });
  EXPECT_GT(lent, 0);
  EXPECT_EQ(forward, 0);
  EXPECT_EQ(niceness(), usual);
}

}  // namespace
}  // namespace likeness
