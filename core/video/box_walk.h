// Boxes of an MP4 or MOV file in order: ISO/IEC 14496-12, section 4.2.
#pragma once

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>

namespace likeness {

struct Box {
  std::string type;         // four characters
  std::uint64_t begin = 0;  // of its contents, as offsets in the file
  std::uint64_t end = 0;    // where it claims to end: before `begin` if that is nonsense
};

// The box whose header is at `at`, within [at, end); nullopt if there is no room for one. A size of zero
// means: up to `end`. Its claimed end may lie beyond `end`: a truncated file.
std::optional<Box> read_box(std::ifstream& file, std::uint64_t at, std::uint64_t end);

// The number encoded by `count` bytes, most significant first.
std::uint64_t big_endian(const char* bytes, int count);

}  // namespace likeness
