// Whole-file reading and atomic writing: see files.h.
#include "core/base/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fmt/format.h>

namespace likeness {

namespace fs = std::filesystem;

namespace {

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int get() const { return fd_; }
  int release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

// Writes everything or returns errno.
int write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    bytes = bytes.subspan(std::size_t(written));
  }
  return 0;
}

// The rename itself must survive a power cut: the folder's entry is flushed too. Best effort.
void sync_folder(const fs::path& folder) {
  const FileDescriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY));
  if (fd.get() >= 0) ::fsync(fd.get());
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

Result<void> rename_into_place(const fs::path& temporary, const fs::path& path) {
  if (::rename(temporary.c_str(), path.c_str()) != 0) {
    const int error_number = errno;
    ::unlink(temporary.c_str());
    return file_error(path, "write", error_number);
  }
  sync_folder(folder_of(path));
  return {};
}

}  // namespace

Error file_error(const fs::path& path, std::string_view action, int error_number) {
  const std::string what =
      fmt::format("Cannot {} {}: {}.", action, path.string(), std::strerror(error_number));
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
      return {ErrorCode::no_space, what, "Free some disk space, or choose another folder, then run it again.",
              path.string()};
    case EROFS:
    case EACCES:
    case EPERM:
      return {ErrorCode::io, what, "Choose a folder you may write to, or change its permissions.",
              path.string()};
    case ENOENT:
      return {ErrorCode::not_found, what, "Check the spelling of the path.", path.string()};
    case ENOTDIR:
      return {ErrorCode::io, what, "There is a file where a folder is needed; choose another name.",
              path.string()};
    default:
      return {ErrorCode::io, what, "Check the disk and the path, then run it again.", path.string()};
  }
}

bool path_exists(const fs::path& path) {
  std::error_code ignored;
  return !path.empty() && fs::exists(path, ignored);
}

Result<std::vector<std::byte>> read_file(const fs::path& path) {
  const FileDescriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0) return file_error(path, "open", errno);
  struct stat status {};
  if (::fstat(fd.get(), &status) != 0) return file_error(path, "read", errno);
  if (S_ISDIR(status.st_mode)) return file_error(path, "read", EISDIR);
  std::vector<std::byte> bytes(std::size_t(std::max<off_t>(status.st_size, 0)));
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t got = ::read(fd.get(), bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return file_error(path, "read", errno);
    if (got == 0) break;
    filled += std::size_t(got);
  }
  bytes.resize(filled);
  return bytes;
}

Result<std::string> read_text(const fs::path& path) {
  auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

Result<void> write_file(const fs::path& path, std::span<const std::byte> bytes) {
  std::error_code failure;
  fs::create_directories(folder_of(path), failure);
  if (failure) return file_error(folder_of(path), "create", failure.value());
  const fs::path temporary = temporary_name(path);
  FileDescriptor fd(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (fd.get() < 0) return file_error(path, "write", errno);
  int error_number = write_all(fd.get(), bytes);
  if (error_number == 0 && ::fsync(fd.get()) != 0) error_number = errno;
  if (::close(fd.release()) != 0 && error_number == 0) error_number = errno;
  if (error_number != 0) {
    ::unlink(temporary.c_str());
    return file_error(path, "write", error_number);
  }
  return rename_into_place(temporary, path);
}

Result<void> write_text(const fs::path& path, std::string_view text) {
  return write_file(path, std::as_bytes(std::span(text.data(), text.size())));
}

Result<void> make_writable_folder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) return file_error(folder, "create", failure.value());
  if (!fs::is_directory(folder, failure)) return file_error(folder, "create", ENOTDIR);
  const fs::path probe = temporary_name(folder / "probe");
  const FileDescriptor fd(::open(probe.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (fd.get() < 0) return file_error(folder, "write into", errno);
  // An empty file costs no block; a byte reveals a full disk now rather than after an hour's work.
  const std::byte byte{};
  int error_number = write_all(fd.get(), std::span(&byte, 1));
  if (error_number == 0 && ::fsync(fd.get()) != 0) error_number = errno;
  ::unlink(probe.c_str());
  if (error_number != 0) return file_error(folder, "write into", error_number);
  return {};
}

fs::path temporary_name(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  return folder_of(path) / fmt::format(".{}.{}-{}.part{}", path.stem().string(), ::getpid(),
                                       counter.fetch_add(1), path.extension().string());
}

Result<void> commit_file(const fs::path& temporary, const fs::path& path) {
  const FileDescriptor fd(::open(temporary.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0) return file_error(path, "write", errno);
  if (::fsync(fd.get()) != 0) {
    const int error_number = errno;
    ::unlink(temporary.c_str());
    return file_error(path, "write", error_number);
  }
  return rename_into_place(temporary, path);
}

}  // namespace likeness
