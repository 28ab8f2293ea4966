// Running the real command line in a test: exit code, both outputs, and killing it part-way.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace likeness::test {

struct ProgramResult {
  int exit_code = -1;  // 128 + signal when killed
  std::string out, err;
};

// Runs a program to its end with standard output and error captured.
ProgramResult run_program(const std::vector<std::string>& command);

// Starts a program in the background, its outputs to files in `folder`; wait_program() collects it.
pid_t start_program(const std::vector<std::string>& command, const std::filesystem::path& folder);
int wait_program(pid_t child);

// The `likeness` just built.
ProgramResult likeness(std::vector<std::string> arguments);
std::string likeness_path();

// From now on, whatever this process starts writes down in this file where it turns to a network
// (watch_connect.cpp).
void watch_calls(const std::filesystem::path& file);

}  // namespace likeness::test
