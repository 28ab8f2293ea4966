// Bytes that are not UTF-8, there and back: see path_text.h.
#include "core/base/path_text.h"

#include <cstddef>
#include <optional>

namespace likeness {
namespace {

constexpr std::string_view kStandsForByte =
    "\xf4\x8f";  // how U+10FE00 to U+10FEFF begin; two more bytes follow

unsigned byte_at(std::string_view text, std::size_t i) {
  return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
}

// The length of the well-formed character at the front (RFC 3629); 0 if there is none.
std::size_t character_length(std::string_view text) {
  const unsigned first = byte_at(text, 0), second = byte_at(text, 1);
  if (first < 0x80) return 1;
  const std::size_t length = first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : first < 0xf5 ? 4 : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte_at(text, i) & 0xc0) != 0x80) return 0;
  const bool overlong = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90),
             beyond = (first == 0xed && second > 0x9f) || (first == 0xf4 && second > 0x8f);
  return overlong || beyond ? 0 : length;
}

// The byte for which the character at the front stands.
std::optional<char> stands_for(std::string_view text) {
  if (!text.starts_with(kStandsForByte) || character_length(text) != 4) return std::nullopt;
  const unsigned third = byte_at(text, 2), fourth = byte_at(text, 3);
  if (third < 0xb8 || third > 0xbb) return std::nullopt;
  return static_cast<char>((third & 3) << 6 | (fourth & 0x3f));
}

std::string standing_for(unsigned byte) {
  return std::string(kStandsForByte) + static_cast<char>(0xb8 | byte >> 6) +
         static_cast<char>(0x80 | (byte & 0x3f));
}

}  // namespace

std::string text_of_path(const std::filesystem::path& path) {
  std::string text;
  for (std::string_view rest = path.native(); !rest.empty();) {
    const std::size_t length = character_length(rest);
    // A name that has such a character of its own comes back, too.
    const bool as_it_is = length > 0 && !stands_for(rest);
    const std::size_t taken = as_it_is ? length : 1;
    text += as_it_is ? std::string(rest.substr(0, taken)) : standing_for(byte_at(rest, 0));
    rest.remove_prefix(taken);
  }
  return text;
}

std::filesystem::path path_of_text(std::string_view text) {
  std::string bytes;
  while (!text.empty()) {
    const auto byte = stands_for(text);
    bytes += byte ? *byte : text.front();
    text.remove_prefix(byte ? 4 : 1);
  }
  return bytes;
}

}  // namespace likeness
