// See run_program.h.
#include "tests/support/run_program.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

namespace likeness::test {

namespace fs = std::filesystem;

namespace {

std::string slurp(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

pid_t start_program(const std::vector<std::string>& command, const fs::path& folder) {
  std::vector<char*> arguments;
  for (const std::string& part : command) arguments.push_back(const_cast<char*>(part.c_str()));
  arguments.push_back(nullptr);
  const std::string out = (folder / "out").string(), err = (folder / "err").string();
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int out_fd = ::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  const int err_fd = ::open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  ::dup2(out_fd, STDOUT_FILENO);
  ::dup2(err_fd, STDERR_FILENO);
  ::execvp(arguments[0], arguments.data());
  ::_exit(127);
}

int wait_program(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

ProgramResult run_program(const std::vector<std::string>& command) {
  std::string name = (fs::temp_directory_path() / "likeness_run_XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) return {};
  const fs::path folder = name;
  ProgramResult result;
  result.exit_code = wait_program(start_program(command, folder));
  result.out = slurp(folder / "out");
  result.err = slurp(folder / "err");
  fs::remove_all(folder);
  return result;
}

std::string likeness_path() { return std::string(LIKENESS_BIN) + "/likeness"; }

void watch_calls(const fs::path& file) {
  ::setenv("LIKENESS_CALLS", file.c_str(), 1);
  ::setenv("LD_PRELOAD", LIKENESS_WATCH_CONNECT, 1);
}

ProgramResult likeness(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), likeness_path());
  return run_program(arguments);
}

}  // namespace likeness::test
