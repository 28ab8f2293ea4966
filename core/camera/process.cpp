// fork + exec with one pipe; only async-signal-safe calls between the two, as this program has threads.
#include "core/camera/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>

#include "core/base/program_files.h"

namespace likeness {
namespace {

constexpr std::size_t kTailBytes = 6000;

// Splits a stream into lines; a carriage return ends one too (programs that redraw a line).
struct LineReader {
  std::string pending, tail;
  const std::function<void(std::string_view)>& on_line;

  void take(const char* bytes, std::size_t count) {
    tail.append(bytes, count);
    if (tail.size() > 2 * kTailBytes) tail.erase(0, tail.size() - kTailBytes);
    for (std::size_t i = 0; i < count; ++i) {
      if (bytes[i] == '\n' || bytes[i] == '\r')
        flush();
      else
        pending += bytes[i];
    }
  }
  void flush() {
    if (!pending.empty() && on_line) on_line(pending);
    pending.clear();
  }
};

// Waits for the child; escalates from SIGTERM to SIGKILL.
int end_child(pid_t child) {
  kill(-child, SIGTERM);
  kill(child, SIGTERM);
  const auto start = std::chrono::steady_clock::now();
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() - start > std::chrono::seconds(3)) {
      kill(-child, SIGKILL);
      kill(child, SIGKILL);
      while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
      }
      break;
    }
    usleep(10000);
  }
  return status;
}

// Never returns. `pipe_end` becomes standard output and error.
[[noreturn]] void become(char* const* argv, int pipe_end, pid_t parent) {
  setpgid(0, 0);
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(126);
#else
  (void)parent;
#endif
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int null = open("/dev/null", O_RDONLY);
  if (null >= 0) dup2(null, 0);
  dup2(pipe_end, 1);
  dup2(pipe_end, 2);
  execv(argv[0], argv);
  _exit(127);
}

}  // namespace

std::optional<std::filesystem::path> find_program(const std::string& name) {
  const auto runnable = [](const std::filesystem::path& path) {
    std::error_code ignored;
    return std::filesystem::is_regular_file(path, ignored) && access(path.c_str(), X_OK) == 0;
  };
  if (name.find('/') != std::string::npos)
    return runnable(name) ? std::optional<std::filesystem::path>(name) : std::nullopt;
  if (auto own = bundled_file(std::filesystem::path("lib/likeness") / name); own && runnable(*own))
    return own;
  const char* variable = std::getenv("PATH");
  std::string_view folders = variable ? variable : "/usr/local/bin:/usr/bin:/bin";
  while (!folders.empty()) {
    const auto colon = folders.find(':');
    const std::filesystem::path path = std::filesystem::path(folders.substr(0, colon)) / name;
    if (runnable(path)) return path;
    folders = colon == std::string_view::npos ? std::string_view{} : folders.substr(colon + 1);
  }
  return std::nullopt;
}

Result<ProcessEnd> run_process(const std::vector<std::string>& arguments,
                               const std::function<void(std::string_view)>& on_line, std::stop_token stop) {
  if (stop.stop_requested()) return cancelled_error();
  const auto program = arguments.empty() ? std::nullopt : find_program(arguments[0]);
  if (!program)
    return Error{ErrorCode::missing_dependency,
                 fmt::format("The program `{}` was not found.", arguments.empty() ? "" : arguments[0]),
                 "Install it, or add its folder to PATH.", ""};
  std::vector<std::string> copies = arguments;
  copies[0] = program->string();
  std::vector<char*> argv;
  for (auto& argument : copies) argv.push_back(argument.data());
  argv.push_back(nullptr);

  const auto system_error = [&](const char* call) {
    return Error{ErrorCode::failed,
                 fmt::format("Could not start `{}`: {}: {}.", arguments[0], call, strerror(errno)),
                 "Close other programs and try again.", ""};
  };
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return system_error("pipe");
  const pid_t parent = getpid(), child = fork();
  if (child < 0) {
    const Error error = system_error("fork");
    close(ends[0]);
    close(ends[1]);
    return error;
  }
  if (child == 0) become(argv.data(), ends[1], parent);
  close(ends[1]);

  LineReader lines{{}, {}, on_line};
  bool stopped = false;
  for (;;) {
    if (stop.stop_requested()) {
      stopped = true;
      break;
    }
    pollfd wait{ends[0], POLLIN, 0};
    if (poll(&wait, 1, 50) <= 0) continue;
    char buffer[4096];
    const ssize_t count = read(ends[0], buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    lines.take(buffer, std::size_t(count));
  }
  close(ends[0]);
  int status = 0;
  if (stopped) {
    end_child(child);
    return cancelled_error();
  }
  lines.flush();
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  ProcessEnd end;
  end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  end.tail = lines.tail.size() > kTailBytes ? lines.tail.substr(lines.tail.size() - kTailBytes) : lines.tail;
  return end;
}

}  // namespace likeness
