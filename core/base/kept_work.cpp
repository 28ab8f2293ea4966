// See kept_work.h: a line that names the inputs, then pieces, each with its checksum.
#include "core/base/kept_work.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <mutex>
#include <span>
#include <system_error>
#include <utility>

#include "core/base/hash.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::seconds kSyncEvery(30);
constexpr std::size_t kHashLetters = 32;

struct PieceHead {
  std::uint32_t name_bytes = 0, packed_bytes = 0;
  std::uint64_t bytes = 0;                // unpacked
  std::array<char, kHashLetters> hash{};  // of name and packed bytes
};
constexpr std::uint64_t kMostUnfolded = 1040;  // times: deflate reaches no more

std::optional<std::string> packed(std::string_view bytes) {
  uLongf size = compressBound(uLong(bytes.size()));
  if (size > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  std::string out(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                uLong(bytes.size()), Z_BEST_SPEED) != Z_OK)
    return std::nullopt;
  out.resize(size);
  return out;
}

std::array<char, kHashLetters> hash_of_piece(std::string_view name, std::string_view bytes) {
  const std::string text = hash_text(name) + hash_bytes(std::as_bytes(std::span(bytes)));
  std::array<char, kHashLetters> hash{};
  std::memcpy(hash.data(), hash_text(text).data(), kHashLetters);
  return hash;
}

bool read_at(int file, std::uint64_t from, char* to, std::size_t count) {
  while (count > 0) {
    const ssize_t got = ::pread(file, to, count, off_t(from));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    from += std::uint64_t(got), to += got, count -= std::size_t(got);
  }
  return true;
}

bool write_at(int file, std::uint64_t from, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::pwrite(file, bytes.data(), bytes.size(), off_t(from));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return false;
    from += std::uint64_t(put), bytes.remove_prefix(std::size_t(put));
  }
  return true;
}

}  // namespace

struct KeptWork::State {
  struct Place {
    std::uint64_t from = 0;
    std::uint32_t packed_bytes = 0;
    std::uint64_t bytes = 0;
  };

  ~State() {
    if (file >= 0) ::close(file);
  }
  std::uint64_t size() const {
    struct stat about {};
    return ::fstat(file, &about) == 0 ? std::uint64_t(about.st_size) : 0;
  }
  // What a killed process kept; false: nothing of these inputs.
  bool take_over(const std::string& line) {
    std::string own(line.size(), '\0');
    if (!read_at(file, 0, own.data(), own.size()) || own != line) return false;
    end = line.size();
    for (const std::uint64_t all = size(); end < all;) {
      PieceHead head;
      if (all - end < sizeof head || !read_at(file, end, reinterpret_cast<char*>(&head), sizeof head)) break;
      const std::uint64_t left = all - end - sizeof head;
      if (head.name_bytes > left || head.packed_bytes > left - head.name_bytes ||
          head.bytes / kMostUnfolded > head.packed_bytes)
        break;
      std::string name(head.name_bytes, '\0'), bytes(head.packed_bytes, '\0');
      const std::uint64_t from = end + sizeof head + head.name_bytes;
      if (!read_at(file, end + sizeof head, name.data(), name.size()) ||
          !read_at(file, from, bytes.data(), bytes.size()) || hash_of_piece(name, bytes) != head.hash)
        break;
      places[std::move(name)] = {from, head.packed_bytes, head.bytes};
      end = from + head.packed_bytes;
    }
    return true;
  }
  // No room, most often: what was kept takes none of it either.
  void give_up() {
    ::close(std::exchange(file, -1));
    std::error_code ignored;
    fs::remove(path, ignored);
    fs::remove(path.parent_path(), ignored);  // where nothing else is in it
    places.clear();
  }

  fs::path path;
  mutable std::mutex mutex;
  int file = -1;  // -1: nothing is kept
  std::uint64_t end = 0;
  std::map<std::string, Place> places;
  std::chrono::steady_clock::time_point synced = std::chrono::steady_clock::now();
};

KeptWork::KeptWork(fs::path file, const std::string& inputs) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.path = std::move(file);
  std::error_code ignored;
  fs::create_directories(s.path.parent_path(), ignored);
  s.file = ::open(s.path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (s.file < 0) return;
  const std::string line = "likeness kept work 1 " + hash_text(inputs) + "\n";
  if (!s.take_over(line)) s.end = 0;
  const bool begun = s.end > 0;
  if (::ftruncate(s.file, off_t(s.end)) != 0 || (!begun && !write_at(s.file, 0, line)))
    s.give_up();
  else
    s.end = std::max<std::uint64_t>(s.end, line.size());
}

KeptWork::~KeptWork() = default;

std::optional<std::string> KeptWork::find(const std::string& name) const {
  const State& s = *state_;
  const std::lock_guard lock(s.mutex);
  const auto found = s.places.find(name);
  if (found == s.places.end()) return std::nullopt;
  std::string small(found->second.packed_bytes, '\0'), bytes(std::size_t(found->second.bytes), '\0');
  if (!read_at(s.file, found->second.from, small.data(), small.size())) return std::nullopt;
  uLongf size = uLongf(bytes.size());
  if (uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(small.data()),
                 uLong(small.size())) != Z_OK ||
      size != bytes.size())
    return std::nullopt;
  return bytes;
}

void KeptWork::keep(const std::string& name, std::string_view bytes) {
  State& s = *state_;
  const auto small = packed(bytes);
  if (!small) return;
  const PieceHead head{std::uint32_t(name.size()), std::uint32_t(small->size()), bytes.size(),
                       hash_of_piece(name, *small)};
  const std::lock_guard lock(s.mutex);
  if (s.file < 0) return;
  const std::uint64_t from = s.end + sizeof head + name.size();
  if (!write_at(s.file, s.end, {reinterpret_cast<const char*>(&head), sizeof head}) ||
      !write_at(s.file, s.end + sizeof head, name) || !write_at(s.file, from, *small))
    return s.give_up();
  s.places[name] = {from, head.packed_bytes, head.bytes};
  s.end = from + small->size();
  const auto now = std::chrono::steady_clock::now();
  if (now - s.synced < kSyncEvery) return;
  ::fdatasync(s.file);
  s.synced = now;
}

void KeptWork::finish() {
  const std::lock_guard lock(state_->mutex);
  if (state_->file >= 0) state_->give_up();
}

}  // namespace likeness
