// See file_names.h.
#include "core/base/file_names.h"

#include <limits.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <system_error>

#include <fmt/format.h>

namespace likeness {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kBelowProject = 128;  // bytes of the longest path in a project's folder, about

bool is_inner_byte(char byte) { return (static_cast<unsigned char>(byte) & 0xc0) == 0x80; }

// Of the character that begins there; 0xfffd where it is not whole.
std::uint32_t character_at(std::string_view text, std::size_t at) {
  const auto first = static_cast<unsigned char>(text[at]);
  const std::size_t length = first < 0x80 ? 1 : first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (length == 1) return first;
  std::uint32_t value = first & (0x7fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if (at + i >= text.size() || !is_inner_byte(text[at + i])) return 0xfffd;
    value = value << 6 | (static_cast<unsigned char>(text[at + i]) & 0x3f);
  }
  return value;
}

constexpr std::uint32_t kJoiner = 0x200d;

// Belongs to what stands before it: accents, vowel signs of Thai, Hebrew and Arabic points, variation
// selectors, skin tones.
bool is_mark(std::uint32_t c) {
  const auto within = [c](std::uint32_t first, std::uint32_t last) { return c >= first && c <= last; };
  return c == kJoiner || within(0x300, 0x36f) || within(0x591, 0x5c7) || within(0x64b, 0x65f) ||
         within(0x900, 0x903) || within(0x93a, 0x94f) || c == 0xe31 || within(0xe34, 0xe3a) ||
         within(0xe47, 0xe4e) || within(0x1ab0, 0x1aff) || within(0x20d0, 0x20ff) || within(0x3099, 0x309a) ||
         within(0xfe00, 0xfe0f) || within(0x1f3fb, 0x1f3ff) || within(0xe0020, 0xe007f);
}

std::size_t character_before(std::string_view text, std::size_t at) {
  do --at;
  while (at > 0 && is_inner_byte(text[at]));
  return at;
}

// The longest name that the file system of this place takes.
std::size_t longest_name_at(fs::path path) {
  std::error_code ignored;
  while (!path.empty() && !fs::exists(path, ignored) && path != path.parent_path()) path = path.parent_path();
  const long most = ::pathconf(path.empty() ? "." : path.c_str(), _PC_NAME_MAX);
  return most > 0 ? std::size_t(most) : kLongestName;
}

}  // namespace

std::string cut_name(std::string_view name, std::size_t most) {
  if (name.size() <= most) return std::string(name);
  std::size_t end = most;
  while (end > 0 && most - end < 3 && is_inner_byte(name[end])) --end;
  if (is_inner_byte(name[end])) return std::string(name.substr(0, most));
  const std::size_t whole = end;
  while (end > 0 &&
         (is_mark(character_at(name, end)) || character_at(name, character_before(name, end)) == kJoiner))
    end = character_before(name, end);
  return std::string(name.substr(0, end == 0 ? whole : end));
}

std::string name_with(std::string_view stem, std::string_view ending) {
  const std::string kept(ending.substr(0, kLongestName));
  return cut_name(stem, kLongestName - kept.size()) + kept;
}

Result<void> check_can_be_named(const fs::path& path) {
  std::error_code failure;
  const fs::path whole = fs::absolute(path, failure);
  if (failure) return {};
  fs::path place;
  std::optional<std::size_t> most;
  for (const fs::path& name : whole) {
    const std::size_t bytes = name.native().size();
    if (bytes > kLongestName / 2) {  // hardly any are: nobody is asked
      if (!most) most = longest_name_at(place);
      if (bytes > *most)
        return Error{ErrorCode::bad_input,
                     fmt::format("A name has {} bytes, and there at most {} can be used: {}.", bytes, *most,
                                 name.string()),
                     "Choose a shorter name; letters other than English ones take two to four bytes each.",
                     path.string()};
    }
    place /= name;
  }
  if (whole.native().size() + kBelowProject > PATH_MAX)
    return Error{ErrorCode::bad_input,
                 fmt::format("The path has {} bytes, and at most {} can be used.", whole.native().size(),
                             PATH_MAX - kBelowProject),
                 "Choose a folder that lies less deep, or has shorter names above it.", path.string()};
  return {};
}

}  // namespace likeness
