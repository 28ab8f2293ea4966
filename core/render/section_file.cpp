// Writing and defensive reading of section files.
#include "core/render/section_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/check.h"
#include "core/base/files.h"
#include "core/base/hash.h"

namespace likeness {
namespace {

constexpr std::size_t kMagicBytes = 8, kNameBytes = 16, kHashBytes = 32;
constexpr std::size_t kHeaderBytes = kMagicBytes + 8, kEntryBytes = kNameBytes + 16;
constexpr std::size_t kMostSections = 256;

template <class T>
void put(std::vector<std::byte>& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

template <class T>
T get(const std::vector<std::byte>& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

// How long a file with this table of contents is, at most kLargestFile.
std::uint64_t listed_bytes(const std::vector<std::byte>& head, std::size_t count) {
  std::uint64_t bytes = kHeaderBytes + count * kEntryBytes + kHashBytes;
  for (std::size_t i = 0; i < count; ++i)
    bytes +=
        std::min(kLargestFile, get<std::uint64_t>(head, kHeaderBytes + i * kEntryBytes + kNameBytes + 8));
  return std::min(bytes, kLargestFile);
}

Error damaged(const std::filesystem::path& path, const SectionFormat& format, const std::string& detail) {
  return {ErrorCode::bad_input, fmt::format("The {} file is damaged: {}.", format.content, detail),
          std::string(format.remedy), path.string()};
}

}  // namespace

Result<void> write_sections(const std::filesystem::path& path, const SectionFormat& format,
                            const Sections& sections) {
  LIKENESS_CHECK(format.magic.size() == kMagicBytes, "magic of %zu bytes", format.magic.size());
  std::size_t size = kHeaderBytes + sections.size() * kEntryBytes;
  std::size_t at = size;
  for (const auto& [name, data] : sections) size += data.size();
  std::vector<std::byte> bytes(size, std::byte(0));
  bytes.reserve(size + kHashBytes);
  std::memcpy(bytes.data(), format.magic.data(), kMagicBytes);
  put(bytes, kMagicBytes, format.version);
  put(bytes, kMagicBytes + 4, std::uint32_t(sections.size()));
  std::size_t entry = kHeaderBytes;
  for (const auto& [name, data] : sections) {
    LIKENESS_CHECK(name.size() < kNameBytes, "section name %s", name.c_str());
    std::memcpy(bytes.data() + entry, name.data(), name.size());
    put(bytes, entry + kNameBytes, std::uint64_t(at));
    put(bytes, entry + kNameBytes + 8, std::uint64_t(data.size()));
    if (!data.empty()) std::memcpy(bytes.data() + at, data.data(), data.size());
    at += data.size();
    entry += kEntryBytes;
  }
  const std::string hash = hash_bytes(bytes);
  const std::size_t end = bytes.size();
  bytes.resize(end + kHashBytes, std::byte(0));
  std::memcpy(bytes.data() + end, hash.data(), std::min(kHashBytes, hash.size()));
  return write_file(path, bytes);
}

Result<Sections> read_sections(const std::filesystem::path& path, const SectionFormat& format) {
  // A large file of something else, or of nothing, is refused by its head.
  const auto head = read_head(path, kHeaderBytes + kMostSections * kEntryBytes);
  if (!head) return head.error();
  if (head->size() < kHeaderBytes || std::memcmp(head->data(), format.magic.data(), kMagicBytes) != 0)
    return Error{ErrorCode::bad_input, fmt::format("This is not a Likeness {} file.", format.content),
                 std::string(format.remedy), path.string()};
  const auto version = get<std::uint32_t>(*head, kMagicBytes);
  if (version != format.version)
    return Error{ErrorCode::bad_input,
                 fmt::format("The {} file has format version {}; this program reads version {}.",
                             format.content, version, format.version),
                 version > format.version ? "Open it with a newer Likeness." : std::string(format.remedy),
                 path.string()};
  const std::size_t count = get<std::uint32_t>(*head, kMagicBytes + 4);
  if (count > kMostSections || head->size() < kHeaderBytes + count * kEntryBytes)
    return damaged(path, format, "it ends before its table of contents does");
  const auto file = read_file(path, listed_bytes(*head, count));
  if (!file && file.error().code == ErrorCode::bad_input)
    return damaged(path, format, "it is longer than its table of contents says");
  if (!file) return file.error();
  const std::vector<std::byte>& bytes = *file;
  if (bytes.size() < kHeaderBytes + count * kEntryBytes + kHashBytes)
    return damaged(path, format, "it ends before its sections do");
  const std::size_t end = bytes.size() - kHashBytes;
  const std::string hash = hash_bytes(std::span<const std::byte>(bytes.data(), end));
  if (hash.size() != kHashBytes || std::memcmp(bytes.data() + end, hash.data(), kHashBytes) != 0)
    return damaged(path, format, "its checksum does not match (it was cut short or altered)");
  Sections sections;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t entry = kHeaderBytes + i * kEntryBytes;
    const char* text = reinterpret_cast<const char*>(bytes.data() + entry);
    const std::string name(text, strnlen(text, kNameBytes));
    const auto offset = get<std::uint64_t>(bytes, entry + kNameBytes);
    const auto length = get<std::uint64_t>(bytes, entry + kNameBytes + 8);
    if (offset > end || length > end - offset)
      return damaged(path, format, fmt::format("section '{}' lies outside the file", name));
    sections[name].assign(bytes.begin() + std::ptrdiff_t(offset),
                          bytes.begin() + std::ptrdiff_t(offset + length));
  }
  return sections;
}

}  // namespace likeness
