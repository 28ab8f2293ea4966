// A binary file of named sections with a checksum, written whole or not at all: avatar.bin and
// checkpoint.bin.
//
//   magic (8 bytes) | version u32 | section count u32 | per section: name (16 bytes, zero-padded), offset
//   u64, length u64 | the sections | 32 hexadecimal digits: hash of everything before
//
// Little-endian. A reader trusts nothing: every offset and length is checked before use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/result.h"

namespace likeness {

using Sections = std::map<std::string, std::vector<std::byte>>;

struct SectionFormat {
  std::string_view magic;  // 8 characters
  std::uint32_t version = 1;
  std::string_view content;  // what the file is, for messages: "avatar"
  std::string_view remedy;   // what to do if it cannot be used
};

Result<void> write_sections(const std::filesystem::path& path, const SectionFormat& format,
                            const Sections& sections);
Result<Sections> read_sections(const std::filesystem::path& path, const SectionFormat& format);

template <class T>
std::vector<std::byte> to_section(std::span<const T> values) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::vector<std::byte> bytes(values.size_bytes());
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}
template <class T>
std::vector<std::byte> to_section(const std::vector<T>& values) {
  return to_section(std::span<const T>(values));
}

// False when the section is missing or does not hold exactly `count` values.
template <class T>
bool from_section(const Sections& sections, const std::string& name, std::size_t count,
                  std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T>);
  const auto found = sections.find(name);
  if (found == sections.end() || found->second.size() % sizeof(T) != 0 ||
      found->second.size() / sizeof(T) != count)
    return false;
  values.resize(count);
  if (count > 0) std::memcpy(values.data(), found->second.data(), found->second.size());
  return true;
}

}  // namespace likeness
