// Running another program: its output is read line by line as it runs, and it is ended on request.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace likeness {

struct ProcessEnd {
  int exit_code = 0;  // 128 + signal number where a signal ended it
  std::string tail;   // the last few thousand characters of its output
};

// The program's file: `name` itself where it holds a slash, otherwise the one bundled with this program, or
// the first in PATH.
std::optional<std::filesystem::path> find_program(const std::string& name);

// Runs arguments[0] with the rest as arguments, standard output and error together to on_line. On stop the
// child gets SIGTERM, then SIGKILL after three seconds, and is waited for, so none is left behind. A child
// also gets SIGTERM when this process dies.
Result<ProcessEnd> run_process(const std::vector<std::string>& arguments,
                               const std::function<void(std::string_view line)>& on_line,
                               std::stop_token stop);

}  // namespace likeness
