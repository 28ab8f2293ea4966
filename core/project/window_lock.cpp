// See window_lock.h.
#include "core/project/window_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

#include "core/project/own_names.h"

namespace likeness {

WindowLock::WindowLock(const std::filesystem::path& folder) {
  fd_ = ::open((folder / kWindowLock).c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
  if (fd_ < 0) return;
  int failed = ::flock(fd_, LOCK_EX | LOCK_NB);
  while (failed != 0 && errno == EINTR) failed = ::flock(fd_, LOCK_EX | LOCK_NB);
  others_ = failed != 0 && errno == EWOULDBLOCK;
}

WindowLock::~WindowLock() {
  if (fd_ >= 0) ::close(fd_);
}

}  // namespace likeness
