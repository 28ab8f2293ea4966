// See letters.h.
#include "ui/letters.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace likeness::ui {

namespace {

constexpr std::uint32_t kFirstOwn = 0xe000, kLastOwn = 0xf8ff, kUnknown = 0xfffd;
constexpr std::size_t kMost = 6000;  // letters at a time: their pictures fill a texture

struct Letters {
  std::set<ImWchar> shown;
  bool are_new = false;
  std::vector<std::uint32_t> own;  // the letters of the numbers from kFirstOwn on
  std::map<std::uint32_t, ImWchar> number_of;
};
Letters letters;

bool is_own(std::uint32_t c) { return c >= kFirstOwn && c < kFirstOwn + letters.own.size(); }

struct Read {
  std::uint32_t letter = 0;
  std::size_t bytes = 1;
};

// What begins at `at`.
Read read_letter(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::uint32_t first = byte(at);
  if (first < 0x80) return {first, 1};
  const std::size_t bytes = first >= 0xf0 && first < 0xf5 ? 4 : first >= 0xe0 ? 3 : first >= 0xc2 ? 2 : 0;
  const Read broken{kByte + first, 1};
  if (bytes == 0 || first >= 0xf5 || at + bytes > text.size()) return broken;
  std::uint32_t value = first & (0x7fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(at + i) & 0xc0) != 0x80) return broken;
    value = value << 6 | (byte(at + i) & 0x3f);
  }
  const std::uint32_t least = bytes == 4 ? 0x10000 : bytes == 3 ? 0x800 : 0x80;
  if (value < least || value >= kByte || (value >= 0xd800 && value < 0xe000)) return broken;
  return {value, bytes};
}

void append(std::string& text, std::uint32_t c) {
  const auto add = [&](std::uint32_t byte) { text += char(byte); };
  if (c < 0x80) return add(c);
  if (c < 0x800) {
    add(0xc0 | c >> 6);
  } else if (c < 0x10000) {
    add(0xe0 | c >> 12), add(0x80 | (c >> 6 & 0x3f));
  } else {
    add(0xf0 | c >> 18), add(0x80 | (c >> 12 & 0x3f)), add(0x80 | (c >> 6 & 0x3f));
  }
  add(0x80 | (c & 0x3f));
}

// A number for a letter that has none of 16 bits.
ImWchar own_number(std::uint32_t letter) {
  if (const auto known = letters.number_of.find(letter); known != letters.number_of.end())
    return known->second;
  if (kFirstOwn + letters.own.size() > kLastOwn) return ImWchar(kUnknown);
  const auto number = ImWchar(kFirstOwn + letters.own.size());
  letters.own.push_back(letter);
  letters.number_of.emplace(letter, number);
  return number;
}

}  // namespace

std::string for_window(std::string_view text) {
  if (std::ranges::all_of(text, [](unsigned char c) { return c < 0x80; })) return std::string(text);
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const auto [letter, bytes] = read_letter(text, at);
    at += bytes;
    const bool own = letter > 0xffff || (letter >= kFirstOwn && letter <= kLastOwn && !is_own(letter));
    const ImWchar number = own ? own_number(letter) : ImWchar(letter);
    append(result, number);
    if (number < 0x80 || letters.shown.contains(number)) continue;
    if (letters.shown.size() >= kMost) letters.shown.clear();  // what is still shown comes again
    letters.shown.insert(number);
    letters.are_new = true;
  }
  return result;
}

std::string from_window(std::string_view text) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const auto [number, bytes] = read_letter(text, at);
    const std::uint32_t letter = number <= 0xffff ? letter_meant(ImWchar(number)) : number;
    at += bytes;
    letter >= kByte ? void(result += char(letter - kByte)) : append(result, letter);
  }
  return result;
}

const std::set<ImWchar>& letters_shown() { return letters.shown; }

bool take_new_letters() { return std::exchange(letters.are_new, false); }

std::uint32_t letter_meant(ImWchar shown) { return is_own(shown) ? letters.own[shown - kFirstOwn] : shown; }

}  // namespace likeness::ui
