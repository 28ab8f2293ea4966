// See tiny_build.h.
#include "tests/stress/tiny_build.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

#include "core/render/avatar.h"

namespace likeness::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kStageNames[] = {"import", "align", "fit", "train"};

std::string bytes_in(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Lines of strace's log begin with the thread.
int most_calls_of_a_thread(const fs::path& log) {
  std::map<std::string, int> calls;
  std::ifstream file(log);
  int most = 0;
  for (std::string thread, line; file >> thread && std::getline(file, line);)
    if (line.find("resumed>") == std::string::npos) most = std::max(most, ++calls[thread]);
  return most;
}

// The files of a project but its lock and what was decoded for the next stage, which may be made again.
std::set<std::string> names_in(const fs::path& project) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(project)) {
    const std::string name = fs::relative(entry.path(), project).string();
    if (entry.is_regular_file() && name != ".lock" && !name.starts_with("decoded/")) names.insert(name);
  }
  return names;
}

bool tells_time(const std::string& name) {
  return name == "project.json" || name == "training_curve.json" || name == "checkpoint.bin";
}

std::string comparable(const fs::path& project, const std::string& name) {
  if (name != "avatar.bin") return bytes_in(project / name);
  auto avatar = read_avatar(project / name);
  EXPECT_TRUE(avatar.ok()) << avatar.error().what;
  if (!avatar) return {};
  avatar->train_seconds = 0;
  const fs::path copy = project.parent_path() / "timeless.bin";
  EXPECT_TRUE(write_avatar(copy, *avatar).ok());
  return bytes_in(copy);
}

}  // namespace

std::vector<std::string> straced(std::vector<std::string> command, const std::string& inject,
                                 const fs::path& log) {
  std::vector<std::string> all{"strace", "-f",         "-qqq", "--seccomp-bpf",
                               "-o",     log.string(), "-e",   std::string("trace=") + kWriting};
  if (!inject.empty()) all.insert(all.end(), {"-e", "inject=" + inject});
  all.insert(all.end(), command.begin(), command.end());
  return all;
}

bool can_strace() {
  static const bool can = run_program(straced({"true"}, "")).exit_code == 0;
  return can;
}

const TinyBuild& TinyBuild::get() {
  static const TinyBuild build;
  return build;
}

TinyBuild::TinyBuild() {
  std::string name = (fs::temp_directory_path() / "likeness_stress_XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    ADD_FAILURE() << "no temporary folder";
    return;
  }
  folder_ = name;
  const ProgramResult demo = likeness({"demo", (folder_ / "demo").string(), "--size", "128", "--frames", "30",
                                       "--moving-share", "0", "--samples", "1"});
  EXPECT_EQ(demo.exit_code, 0) << demo.err;
  clip_ = folder_ / "demo" / "demo.mp4";
  const fs::path project = folder_ / "uncut.likeness";
  for (const char* stage_name : kStageNames) {
    TinyStage stage{stage_name, folder_ / (std::string("before_") + stage_name),
                    folder_ / (std::string("after_") + stage_name)};
    if (fs::exists(project)) fs::copy(project, stage.before, fs::copy_options::recursive);
    const auto start = std::chrono::steady_clock::now();
    const fs::path log = folder_ / "log";
    const std::vector<std::string> all = command(stage, project);
    const ProgramResult run = run_program(can_strace() ? straced(all, "", log) : all);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    stage.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (can_strace()) stage.writes = most_calls_of_a_thread(log);
    fs::copy(project, stage.after, fs::copy_options::recursive);
    stages_.push_back(stage);
  }
}

TinyBuild::~TinyBuild() {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

fs::path TinyBuild::copy_before(const TinyStage& stage) const {
  const fs::path project = folder_ / "disturbed.likeness";
  fs::remove_all(project);
  if (fs::exists(stage.before)) fs::copy(stage.before, project, fs::copy_options::recursive);
  return project;
}

std::vector<std::string> TinyBuild::command(const TinyStage& stage, const fs::path& project) const {
  if (stage.name == "import")
    return {likeness_path(), "import", clip_.string(), "--project", project.string()};
  std::vector<std::string> all{likeness_path(), stage.name, project.string()};
  if (stage.name == "train") all.insert(all.end(), {"--steps", "5", "--checkpoint-every", "0.1"});
  return all;
}

void expect_healed(const TinyStage& stage, const fs::path& project) {
  const ProgramResult again = run_program(TinyBuild::get().command(stage, project));
  EXPECT_EQ(again.exit_code, 0) << again.err;
  const std::set<std::string> names = names_in(stage.after);
  EXPECT_EQ(names_in(project), names);
  for (const std::string& name : names) {
    if (tells_time(name)) continue;
    EXPECT_TRUE(comparable(project, name) == comparable(stage.after, name)) << name << " differs";
  }
}

}  // namespace likeness::test
