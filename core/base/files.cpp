// Whole-file reading and atomic writing: see files.h.
#include "core/base/files.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <optional>
#include <random>
#include <regex>
#include <utility>

#include <fmt/format.h>

#include "core/base/file_names.h"
#include "core/base/sync_file.h"
#include "core/base/unfinished.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(other.release()) {}
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int get() const { return fd_; }
  int release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

// Nothing that stands there already, a link least of all, is written through.
int create_new(const fs::path& path) {
  return ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
}

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

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

constexpr const char* kGivenAway = "exports";  // in a project, what is not its owner's alone

// Whether a folder is one that people work in under a lock, or lies in it, and is its owner's alone (mode
// 0700). What is made there is so, too: a face is not for everybody who has an account on the machine.
bool is_private(fs::path folder) {
  for (;; folder = folder_of(folder)) {
    struct stat own {};
    if (::stat(folder.c_str(), &own) != 0 || (own.st_mode & (S_IRWXG | S_IRWXO)) != 0) return false;
    if (folder.filename() == kGivenAway) return false;
    if (::access((folder / ".lock").c_str(), F_OK) == 0) return true;
    if (folder == folder_of(folder)) return false;
  }
}

// Missing folders on the way, too. 0, or errno.
int create_folders(const fs::path& folder) {
  std::error_code ignored;
  if (folder.empty() || fs::is_directory(folder, ignored)) return 0;
  const fs::path above = folder_of(folder);
  if (const int failed = create_folders(above); failed != 0) return failed;
  const bool closed = folder.filename() != kGivenAway && is_private(above);
  if (::mkdir(folder.c_str(), closed ? 0700 : 0777) == 0 || errno == EEXIST) return 0;
  return errno;
}

// The rename itself must survive a power cut: the folder's entry is flushed too. Best effort.
void sync_folder(const fs::path& folder) {
  const FileDescriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY));
  if (fd.get() >= 0) ::fsync(fd.get());
}

Error endless_error(const fs::path& path) {
  return {ErrorCode::bad_input, fmt::format("{} is a pipe or a device, not a file.", path.string()),
          "Write what comes out of it into a file, and name that.", path.string()};
}

struct PlainFile {
  FileDescriptor fd;
  std::uint64_t size = 0;  // bytes
};

// Without waiting for somebody to write into it, as opening a pipe does.
Result<PlainFile> open_plain(const fs::path& path) {
  FileDescriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (fd.get() < 0) return file_error(path, "open", errno);
  struct stat status {};
  if (::fstat(fd.get(), &status) != 0) return file_error(path, "read", errno);
  if (S_ISDIR(status.st_mode)) return file_error(path, "read", EISDIR);
  if (!S_ISREG(status.st_mode)) return endless_error(path);
  return PlainFile{std::move(fd), std::uint64_t(std::max<off_t>(status.st_size, 0))};
}

// Up to `size` bytes from the beginning; fewer where the file became shorter.
Result<std::vector<std::byte>> read_all(const PlainFile& file, const fs::path& path, std::size_t size) {
  std::vector<std::byte> bytes(size);
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t got = ::read(file.fd.get(), bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return file_error(path, "read", errno);
    if (got == 0) break;
    filled += std::size_t(got);
  }
  bytes.resize(filled);
  return bytes;
}

void remove_part(const fs::path& temporary) {
  ::unlink(temporary.c_str());
  forget_unfinished(temporary);
}

Result<void> rename_into_place(const fs::path& temporary, const fs::path& path) {
  if (is_private(folder_of(path))) (void)::chmod(temporary.c_str(), S_IRUSR | S_IWUSR);
  if (::rename(temporary.c_str(), path.c_str()) != 0) {
    const int error_number = errno;
    remove_part(temporary);
    return file_error(path, "write", error_number);
  }
  forget_unfinished(temporary);
  sync_folder(folder_of(path));
  return {};
}

// What of a file's name is in its part's: the longest that leaves room for the rest of it.
constexpr std::size_t kLongestPart = 180;
constexpr std::size_t kLongestExtension = 32;

struct PartName {
  std::string stem, extension;
};
PartName part_name(const fs::path& path) {
  const std::string extension = path.extension().string();
  if (extension.size() > kLongestExtension) return {cut_name(path.filename().string(), kLongestPart), ""};
  return {cut_name(path.stem().string(), kLongestPart), extension};
}

struct Part {
  std::string name;
  pid_t process = 0;
};

// What a name of temporary_name's form says.
std::optional<Part> part_of(const std::string& name) {
  static const std::regex form(R"(\.(.+)\.(\d{1,9})-\d+\.part(\.[^.]*)?)");
  std::smatch found;
  if (!std::regex_match(name, found, form)) return std::nullopt;
  return Part{found[1], pid_t(std::stol(found[2]))};
}

// Pieces of a film, which outlive their process (core/video/finish_film.h).
bool is_recording(const Part& part) { return part.name.ends_with(kRecordingMark); }

}  // namespace

int sync_file(int descriptor) {
  if (::fsync(descriptor) == 0) return 0;
  return errno == EINVAL || errno == ENOSYS || errno == ENOTSUP ? 0 : errno;
}

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
      return {ErrorCode::io, what,
              "Choose a folder you may write to, change its permissions, or copy what you work on to such a "
              "folder.",
              path.string()};
    case ENOENT:
      return {ErrorCode::not_found, what, "Check the spelling of the path.", path.string()};
    case ENAMETOOLONG:
      return {
          ErrorCode::bad_input, what,
          "Choose a shorter name: most disks take 255 bytes, and letters other than English ones take two "
          "to four each.",
          path.string()};
    case EFBIG:
      return {ErrorCode::no_space, what,
              "The disk takes no larger file, as FAT32 does from 4 GB on, or a limit is set (ulimit -f): "
              "choose a folder on another disk, raise the limit, or make less at once; then run it again.",
              path.string()};
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

Result<void> check_not_endless(const fs::path& path) {
  std::error_code ignored;
  const fs::file_type type = fs::status(path, ignored).type();
  const bool endless = type == fs::file_type::fifo || type == fs::file_type::socket ||
                       type == fs::file_type::character || type == fs::file_type::block;
  return endless ? endless_error(path) : Result<void>();
}

Result<std::vector<std::byte>> read_file(const fs::path& path, std::uint64_t most) {
  const auto opened = open_plain(path);
  if (!opened) return opened.error();
  if (opened->size > most)
    return Error{ErrorCode::bad_input,
                 fmt::format("{} has {} MB, more than any such file.", path.string(), opened->size >> 20),
                 "Restore it from a backup, or have it made again.", path.string()};
  return read_all(*opened, path, std::size_t(opened->size));
}

Result<std::string> read_text(const fs::path& path, std::uint64_t most) {
  auto bytes = read_file(path, most);
  if (!bytes) return bytes.error();
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

Result<std::vector<std::byte>> read_head(const fs::path& path, std::size_t most) {
  const auto opened = open_plain(path);
  if (!opened) return opened.error();
  return read_all(*opened, path, std::size_t(std::min<std::uint64_t>(opened->size, most)));
}

Result<void> write_file(const fs::path& path, std::span<const std::byte> bytes) {
  if (const int failed = create_folders(folder_of(path)); failed != 0)
    return file_error(folder_of(path), "create", failed);
  const fs::path temporary = temporary_name(path);
  FileDescriptor fd(create_new(temporary));
  if (const int error_number = errno; fd.get() < 0) {
    forget_unfinished(temporary);
    return file_error(path, "write", error_number);
  }
  int error_number = write_all(fd.get(), bytes);
  if (error_number == 0) error_number = sync_file(fd.get());
  if (::close(fd.release()) != 0 && error_number == 0) error_number = errno;
  if (error_number != 0) {
    remove_part(temporary);
    return file_error(path, "write", error_number);
  }
  return rename_into_place(temporary, path);
}

Result<void> write_text(const fs::path& path, std::string_view text) {
  return write_file(path, std::as_bytes(std::span(text.data(), text.size())));
}

Result<void> make_writable_folder(const fs::path& folder) {
  if (const int failed = create_folders(folder); failed != 0) return file_error(folder, "create", failed);
  std::error_code failure;
  if (!fs::is_directory(folder, failure)) return file_error(folder, "create", ENOTDIR);
  const fs::path probe = temporary_name(folder / "probe");
  const FileDescriptor fd(create_new(probe));
  if (const int error_number = errno; fd.get() < 0) {
    forget_unfinished(probe);
    return file_error(folder, "write into", error_number);
  }
  // An empty file costs no block; a byte reveals a full disk now rather than after an hour's work.
  const std::byte byte{};
  int error_number = write_all(fd.get(), std::span(&byte, 1));
  if (error_number == 0) error_number = sync_file(fd.get());
  remove_part(probe);
  if (error_number != 0) return file_error(folder, "write into", error_number);
  return {};
}

fs::path temporary_name(const fs::path& path) {
  static std::atomic<std::uint64_t> next{std::uint64_t(std::random_device()()) << 32 |
                                         std::random_device()()};
  const auto [stem, extension] = part_name(path);
  fs::path temporary = folder_of(path) / fmt::format(".{}.{}-{}.part{}", stem, ::getpid(),
                                                     next.fetch_add(0x9E3779B97F4A7C15u) >> 40, extension);
  remember_unfinished(temporary);
  return temporary;
}

bool is_part_name(const std::string& name) { return part_of(name).has_value(); }

void remove_abandoned_parts(const fs::path& folder, std::string_view of) {
  std::error_code ignored;
  std::vector<fs::path> abandoned;
  const std::string name = cut_name(of, kLongestPart);
  for (fs::directory_iterator it(folder, ignored), end; !ignored && it != end; it.increment(ignored)) {
    const auto part = part_of(it->path().filename().string());
    const bool lives = part && (::kill(part->process, 0) == 0 || errno != ESRCH);
    if (part && !lives && !is_recording(*part) && (name.empty() || part->name == name))
      abandoned.push_back(it->path());
  }
  for (const fs::path& path : abandoned) fs::remove_all(path, ignored);
}

Result<void> commit_file(const fs::path& temporary, const fs::path& path) {
  const FileDescriptor fd(::open(temporary.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0) return file_error(path, "write", errno);
  if (const int error_number = sync_file(fd.get()); error_number != 0) {
    remove_part(temporary);
    return file_error(path, "write", error_number);
  }
  return rename_into_place(temporary, path);
}

}  // namespace likeness
