// A child starts the desktop's program and ends at once, so that the program is no child of this one and need
// not be waited for. Only async-signal-safe calls between fork and exec, as this program has threads.
#include "ui/platform/show_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/camera/process.h"

namespace likeness::ui {
namespace {

[[noreturn]] void leave_running(char* const* argv) {
  setsid();
  const pid_t program = fork();
  if (program != 0) _exit(program < 0 ? 1 : 0);
  const int null = open("/dev/null", O_RDWR);
  for (int stream = 0; null >= 0 && stream < 3; ++stream) dup2(null, stream);
  execv(argv[0], argv);
  _exit(127);
}

}  // namespace

Result<void> show_folder(const std::filesystem::path& folder) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored))
    return Error{ErrorCode::not_found, fmt::format("There is no folder {}.", folder.string()),
                 "It is created with the first export.", ""};
  const auto program = find_program("xdg-open");
  if (!program)
    return Error{ErrorCode::missing_dependency, "The program `xdg-open`, which shows folders, was not found.",
                 fmt::format("Open {} in your file manager, or install xdg-utils.", folder.string()), ""};
  std::string name = program->string(), what = folder.string();
  char* const argv[] = {name.data(), what.data(), nullptr};
  const pid_t child = fork();
  if (child == 0) leave_running(argv);
  int status = 0;
  if (child > 0)
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
  if (child < 0 || status != 0)
    return Error{ErrorCode::failed,
                 fmt::format("Could not start `xdg-open`: {}.",
                             child < 0 ? strerror(errno) : "no process could be created"),
                 fmt::format("Close other programs, or open {} in your file manager.", folder.string()), ""};
  return {};
}

}  // namespace likeness::ui
