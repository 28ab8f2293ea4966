// Box headers: see box_walk.h.
#include "core/video/box_walk.h"

namespace likeness {

std::uint64_t big_endian(const char* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | std::uint8_t(bytes[i]);
  return value;
}

std::optional<Box> read_box(std::ifstream& file, std::uint64_t at, std::uint64_t end) {
  if (at + 8 > end) return std::nullopt;
  char header[16] = {};
  file.clear();
  file.seekg(std::streamoff(at));
  file.read(header, 16);
  std::uint64_t size = big_endian(header, 4), head = 8;
  if (size == 1) size = big_endian(header + 8, 8), head = 16;
  if (size == 0) size = end - at;
  return Box{std::string(header + 4, 4), at + head, size > UINT64_MAX - at ? UINT64_MAX : at + size};
}

}  // namespace likeness
