// Kills: a stage is ended at a random moment, or at its n-th system call of writing, or the power fails
// there; the same command then ends as if nothing had been.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <random>
#include <thread>

#include "tests/stress/tiny_build.h"
#include "tests/support/trials.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;

// A stage of the tiny build, each as often.
const TinyStage& drawn_stage(std::uint64_t number) {
  const auto& stages = TinyBuild::get().stages();
  return stages[number % stages.size()];
}

std::uint64_t drawn(std::uint64_t number, std::uint64_t count) {
  return std::mt19937_64(number)() % std::max<std::uint64_t>(count, 1);
}

TEST(Kills, AtAnyMoment) {
  run_trials("kills at any moment", [](std::uint64_t number) {
    const TinyStage& stage = drawn_stage(number);
    const fs::path project = TinyBuild::get().copy_before(stage);
    const double after_s = 1e-3 * double(drawn(number, std::uint64_t(1000 * stage.seconds)));
    SCOPED_TRACE(stage.name + " killed after " + std::to_string(after_s) + " s");
    const pid_t child = start_program(TinyBuild::get().command(stage, project), TinyBuild::get().folder());
    std::this_thread::sleep_for(std::chrono::duration<double>(after_s));
    ::kill(child, SIGKILL);
    wait_program(child);
    expect_healed(stage, project);
  });
}

TEST(Kills, AtEveryWrite) {
  if (!can_strace()) GTEST_SKIP() << "strace is not installed, or may not follow programs here";
  run_trials("kills at a write", [](std::uint64_t number) {
    const TinyStage& stage = drawn_stage(number);
    const fs::path project = TinyBuild::get().copy_before(stage);
    const std::uint64_t at = 1 + drawn(number, std::uint64_t(stage.writes));
    SCOPED_TRACE(stage.name + " killed at call " + std::to_string(at) + " of writing");
    run_program(straced(TinyBuild::get().command(stage, project),
                        std::string(kWriting) + ":signal=KILL:when=" + std::to_string(at)));
    expect_healed(stage, project);
  });
}

// See power_cut.cpp: what was not synced is lost.
TEST(Kills, APowerCut) {
  run_trials("power cuts", [](std::uint64_t number) {
    const TinyStage& stage = drawn_stage(number);
    const fs::path project = TinyBuild::get().copy_before(stage), kept = TinyBuild::get().folder() / "kept";
    fs::remove_all(kept), fs::create_directories(kept);
    const std::uint64_t at = 1 + drawn(number, std::uint64_t(stage.writes) / 3);
    SCOPED_TRACE(stage.name + " cut at call " + std::to_string(at) + " of syncing, renaming or removing");
    std::vector<std::string> command{"env",
                                     std::string("LD_PRELOAD=") + LIKENESS_POWER_CUT,
                                     "LIKENESS_CUT_AT=" + std::to_string(at),
                                     "LIKENESS_CUT_SEED=" + std::to_string(number),
                                     "LIKENESS_CUT_BELOW=" + project.string(),
                                     "LIKENESS_CUT_KEPT=" + kept.string()};
    for (const std::string& word : TinyBuild::get().command(stage, project)) command.push_back(word);
    run_program(command);
    expect_healed(stage, project);
  });
}

}  // namespace
}  // namespace likeness::test
