// See standard_streams.h.
#include "app/standard_streams.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

namespace likeness::app {

namespace {

// Of a pipe: what failed before may have left no errno.
bool nobody_reads() {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&out, 1, 0) == 1 && (out.revents & POLLERR) != 0;
}

}  // namespace

void open_standard_streams() {
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error with a remedy, not the end
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(descriptor, F_GETFD) < 0 && errno == EBADF) [[maybe_unused]]
      const int lowest = ::open("/dev/null", descriptor == STDIN_FILENO ? O_RDONLY : O_WRONLY);
}

std::string visible(std::string_view text) {
  std::string shown(text);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const auto c = static_cast<unsigned char>(shown[i]);
    if ((c < 0x20 && c != '\n' && c != '\t') || c == 0x7f) shown[i] = '?';
    // U+0080 to U+009F, in UTF-8
    if (c == 0xc2 && i + 1 < shown.size() && (static_cast<unsigned char>(shown[i + 1]) & 0xe0) == 0x80)
      shown.replace(i, 2, "?");
  }
  return shown;
}

void tell_text(std::string_view text) noexcept {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

void clear_line() noexcept {
  if (::isatty(STDERR_FILENO) != 0) tell_text("\r\033[K");
}

int after_output(int exit_code) {
  errno = 0;
  std::cout.flush();
  const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good();
  if (written || errno == EPIPE || nobody_reads()) return exit_code;  // who read it had enough
  tell(
      "What this command prints could not be written{}{}.\nFree some disk space, or send it elsewhere; then "
      "run it again.\n",
      errno != 0 ? ": " : "", errno != 0 ? std::strerror(errno) : "");
  return exit_code == kExitDone ? kExitFailed : exit_code;
}

}  // namespace likeness::app
