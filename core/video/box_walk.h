// Boxes of an MP4 or MOV file, one after the other: ISO/IEC 14496-12, section 4.2.
#pragma once

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>

namespace likeness {

struct Box {
  std::string type;         // four characters
  std::uint64_t begin = 0;  // of what it holds, as places in the file
  std::uint64_t end = 0;    // where it says that it ends: before `begin` where that is nonsense
};

// The box whose header stands at `at`, within [at, end); nullopt where there is no room for one. A size of
// zero means: up to `end`. What it says may lie beyond `end`: a file that was cut off.
std::optional<Box> read_box(std::ifstream& file, std::uint64_t at, std::uint64_t end);

// The number that `count` bytes are, the first the greatest.
std::uint64_t big_endian(const char* bytes, int count);

}  // namespace likeness
