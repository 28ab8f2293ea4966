// Claims about running other programs.
#include "core/camera/process.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <thread>

namespace likeness {
namespace {

TEST(Process, ReportsLinesAsTheyComeAndTheExitCode) {
  std::vector<std::string> lines;
  const auto end = run_process({"/bin/sh", "-c", "echo one; echo two >&2; printf three; exit 7"},
                               [&](std::string_view line) { lines.emplace_back(line); }, {});
  ASSERT_TRUE(end.ok()) << end.error().what;
  EXPECT_EQ(end->exit_code, 7);
  EXPECT_EQ(lines, (std::vector<std::string>{"one", "two", "three"}));
}

TEST(Process, KeepsOnlyTheTailOfLongOutput) {
  const auto end =
      run_process({"/bin/sh", "-c", "i=0; while [ $i -lt 5000 ]; do echo line $i; i=$((i+1)); done"}, {}, {});
  ASSERT_TRUE(end.ok());
  EXPECT_LT(end->tail.size(), 20000u);
  EXPECT_NE(end->tail.find("line 4999"), std::string::npos);
}

TEST(Process, AMissingProgramIsAMissingDependency) {
  EXPECT_FALSE(find_program("likeness-no-such-program").has_value());
  const auto end = run_process({"likeness-no-such-program"}, {}, {});
  ASSERT_FALSE(end.ok());
  EXPECT_EQ(end.error().code, ErrorCode::missing_dependency);
}

TEST(Process, AKilledChildReportsItsSignal) {
  const auto end = run_process({"/bin/sh", "-c", "kill -KILL $$"}, {}, {});
  ASSERT_TRUE(end.ok());
  EXPECT_EQ(end->exit_code, 128 + SIGKILL);
}

TEST(Process, StoppingEndsTheChildAndLeavesNoneBehind) {
  std::stop_source stop;
  pid_t child = 0;
  // The child says its number, starts a grandchild and would run for a minute.
  const auto end = run_process(
      {"/bin/sh", "-c", "echo $$; sleep 60 & wait"},
      [&](std::string_view line) {
        child = std::atoi(std::string(line).c_str());
        stop.request_stop();
      },
      stop.get_token());
  ASSERT_FALSE(end.ok());
  EXPECT_EQ(end.error().code, ErrorCode::cancelled);
  ASSERT_GT(child, 0);
  EXPECT_EQ(kill(child, 0), -1);  // gone and waited for
}

TEST(Process, StoppedBeforeTheStartRunsNothing) {
  std::stop_source stop;
  stop.request_stop();
  bool spoke = false;
  const auto end = run_process(
      {"/bin/sh", "-c", "echo x"}, [&](std::string_view) { spoke = true; }, stop.get_token());
  EXPECT_FALSE(end.ok());
  EXPECT_FALSE(spoke);
}

}  // namespace
}  // namespace likeness
