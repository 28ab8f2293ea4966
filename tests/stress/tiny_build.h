// The smallest film that passes every stage, built once: what there was before and after each stage, so that
// a stage can be disturbed and repeated by itself.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/run_program.h"

namespace likeness::test {

struct TinyStage {
  std::string name;
  std::filesystem::path before, after;  // the project; what `after` holds is what an undisturbed run leaves
  double seconds = 0;                   // that one run took
  int writes = 0;  // system calls of writing, of the thread with most; 0: strace cannot count them here
};

class TinyBuild {
 public:
  // Made at the first call, in a temporary folder that the process removes at its end.
  static const TinyBuild& get();
  ~TinyBuild();

  const std::vector<TinyStage>& stages() const { return stages_; }
  // A copy of the project as it was before the stage.
  std::filesystem::path copy_before(const TinyStage& stage) const;
  // What the user types to run the stage on that copy.
  std::vector<std::string> command(const TinyStage& stage, const std::filesystem::path& project) const;
  const std::filesystem::path& folder() const { return folder_; }

 private:
  TinyBuild();
  std::filesystem::path folder_, clip_;
  std::vector<TinyStage> stages_;
};

// The system calls by which programs write, for strace's -e trace= and inject=.
inline constexpr const char* kWriting =
    "write,writev,pwrite64,ftruncate,fsync,fdatasync,rename,renameat,renameat2,unlink,unlinkat,mkdir,close";
// {"strace", ..., "-e", inject} before a command.
std::vector<std::string> straced(std::vector<std::string> command, const std::string& inject,
                                 const std::filesystem::path& log = "/dev/null");
// Whether strace can follow a program here.
bool can_strace();

// Runs the stage again on a project that was disturbed and expects what an undisturbed run leaves, to the bit
// but for what tells the time, and nothing beside it.
void expect_healed(const TinyStage& stage, const std::filesystem::path& project);

}  // namespace likeness::test
