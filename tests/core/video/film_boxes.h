// The boxes of a QuickTime film that hold its metadata, made by hand, without pictures.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace likeness::test {

inline constexpr const char* kFocalTag = "com.apple.quicktime.camera.focal_length.35mm_equivalent";

// Of any width, padded with leading zeros.
inline std::string number(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += i < 8 ? char(value >> (8 * i) & 0xff) : '\0';
  return text;
}
inline std::string box(const std::string& type, const std::string& held) {
  return number(held.size() + 8, 4) + type + held;
}

struct Tag {
  std::string key;
  std::uint64_t type = 1;
  std::string bytes;
};

inline std::string meta(const std::vector<Tag>& tags, const std::string& before = "") {
  std::string keys = number(0, 4) + number(tags.size(), 4), list;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    keys += number(tags[i].key.size() + 8, 4) + "mdta" + tags[i].key;
    list += box(number(i + 1, 4), box("data", number(tags[i].type, 4) + number(0, 4) + tags[i].bytes));
  }
  const std::string handler = number(0, 8) + "mdta" + number(0, 13);
  return box("meta", before + box("hdlr", handler) + box("keys", keys) + box("ilst", list));
}

inline std::string film(const std::string& of_track, const std::string& of_film = "") {
  return box("ftyp", "qt  " + number(0, 4) + "qt  ") + box("mdat", std::string(100, 'x')) +
         box("moov", box("mvhd", std::string(100, '\0')) +
                         box("trak", box("tkhd", number(0, 84)) + of_track) + of_film);
}

}  // namespace likeness::test
