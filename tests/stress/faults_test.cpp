// Faults: a system call of writing fails once, or memory is refused once. What comes of it is an error that
// says so, or the right result; never a crash, and never a wrong file.
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <vector>

#include "tests/stress/tiny_build.h"
#include "tests/support/trials.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;

// A run that was disturbed: all went well, or it failed with a sentence that is not "an unexpected error".
void expect_clean_end(const ProgramResult& run) {
  if (run.exit_code == 127 && run.err.find("loading shared libraries") != std::string::npos)
    return;  // the system's loader met it, before the program began
  EXPECT_TRUE(run.exit_code == 0 || run.exit_code == 1) << "exit code " << run.exit_code << "\n" << run.err;
  if (run.exit_code != 0) {
    EXPECT_FALSE(run.err.empty());
    EXPECT_EQ(run.err.find("unexpected"), std::string::npos) << run.err;
  }
}

void expect_no_parts(const fs::path& project) {
  if (!fs::exists(project)) return;
  for (const auto& entry : fs::recursive_directory_iterator(project))
    EXPECT_EQ(entry.path().filename().string().find(".part"), std::string::npos) << entry.path() << " stays";
}

TEST(Faults, ACallOfWritingFails) {
  if (!can_strace()) GTEST_SKIP() << "strace is not installed, or may not follow programs here";
  // Each call with the errors that it may end with.
  const std::pair<const char*, std::vector<const char*>> kCalls[] = {
      {"write,writev,pwrite64", {"ENOSPC", "EIO", "EINTR", "EDQUOT"}},
      {"fsync,fdatasync", {"EIO", "ENOSPC", "EDQUOT", "EINTR"}},
      {"rename,renameat,renameat2", {"ENOSPC", "EIO", "EDQUOT"}},
      {"ftruncate", {"EIO", "EINTR"}},
      {"mkdir", {"ENOSPC", "EIO", "EDQUOT"}},
      {"close", {"EIO", "ENOSPC", "EINTR"}},
      {"unlink,unlinkat", {"EIO"}}};
  run_trials("failing calls", [&](std::uint64_t number) {
    std::mt19937_64 random(number);
    const auto& stages = TinyBuild::get().stages();
    const TinyStage& stage = stages[number % stages.size()];
    const auto& [calls, errors] = kCalls[random() % std::size(kCalls)];
    const fs::path project = TinyBuild::get().copy_before(stage);
    const std::string inject = std::string(calls) + ":error=" + errors[random() % errors.size()] +
                               ":when=" + std::to_string(1 + random() % std::uint64_t(stage.writes / 3 + 1));
    SCOPED_TRACE(stage.name + " with " + inject);
    const ProgramResult run = run_program(straced(TinyBuild::get().command(stage, project), inject));
    expect_clean_end(run);
    // A removal that fails leaves what it would have removed to the next run.
    if (!std::string(calls).starts_with("unlink")) expect_no_parts(project);
    expect_healed(stage, project);
  });
}

// What a stage asks of memory, as refused_memory.cpp reports it.
struct Requests {
  std::uint64_t count = 0;
  std::vector<std::uint64_t> places;
};

std::vector<std::string> with_memory_layer(const std::vector<std::string>& command,
                                           const std::string& setting) {
  std::vector<std::string> all{"env", std::string("LD_PRELOAD=") + LIKENESS_REFUSED_MEMORY,
                               "LIKENESS_MEMORY_" + setting};
  all.insert(all.end(), command.begin(), command.end());
  return all;
}

const Requests& requests_of(const TinyStage& stage) {
  static std::map<std::string, Requests> known;
  if (const auto found = known.find(stage.name); found != known.end()) return found->second;
  const fs::path report = TinyBuild::get().folder() / "requests";
  const fs::path project = TinyBuild::get().copy_before(stage);
  const ProgramResult run =
      run_program(with_memory_layer(TinyBuild::get().command(stage, project), "REPORT=" + report.string()));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  Requests& requests = known[stage.name];
  std::ifstream file(report);
  file >> requests.count;
  for (std::uint64_t place = 0; file >> place;) requests.places.push_back(place);
  EXPECT_GT(requests.places.size(), 100u) << "the program was not watched";
  return requests;
}

void refuse(std::uint64_t number, bool by_place) {
  const auto& stages = TinyBuild::get().stages();
  const TinyStage& stage = stages[number % stages.size()];
  const Requests& requests = requests_of(stage);
  if (requests.places.empty()) return;
  const std::uint64_t at = 1 + std::mt19937_64(number)() % requests.count;
  const std::uint64_t place = requests.places[number / stages.size() % requests.places.size()];
  const std::string setting = by_place ? "PLACE=" + std::to_string(place) : "REFUSE=" + std::to_string(at);
  SCOPED_TRACE(stage.name + " with " + setting);
  const fs::path project = TinyBuild::get().copy_before(stage);
  const ProgramResult run = run_program(with_memory_layer(TinyBuild::get().command(stage, project), setting));
  expect_clean_end(run);
  expect_no_parts(project);
  expect_healed(stage, project);
}

TEST(Faults, MemoryIsRefusedAtARequest) {
  run_trials("refused requests", [](std::uint64_t number) { refuse(number, false); });
}

TEST(Faults, MemoryIsRefusedAtAPlace) {
  run_trials("refused places", [](std::uint64_t number) { refuse(number, true); });
}

}  // namespace
}  // namespace likeness::test
