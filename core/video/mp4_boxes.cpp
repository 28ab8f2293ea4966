// Walk over the outermost boxes of an MP4 file: see mp4_boxes.h. ISO/IEC 14496-12, section 4.2.
#include "core/video/mp4_boxes.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <string_view>

namespace likeness {
namespace {

std::uint64_t big_endian(const char* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | std::uint8_t(bytes[i]);
  return value;
}

bool may_come_first(std::string_view type) {
  constexpr std::array<std::string_view, 7> kinds = {"ftyp", "moov", "mdat", "wide", "free", "skip", "pnot"};
  return std::find(kinds.begin(), kinds.end(), type) != kinds.end();
}

}  // namespace

Mp4Boxes scan_mp4_boxes(const std::filesystem::path& path) {
  Mp4Boxes boxes;
  std::error_code failure;
  const std::uint64_t file_size = std::filesystem::file_size(path, failure);
  std::ifstream file(path, std::ios::binary);
  if (failure || !file) return boxes;
  std::uint64_t position = 0;
  while (position + 8 <= file_size) {
    char header[16] = {};
    file.clear();
    file.seekg(std::streamoff(position));
    file.read(header, 16);
    const std::string_view type(header + 4, 4);
    if (position == 0) boxes.is_mp4 = may_come_first(type);
    if (!boxes.is_mp4) return boxes;
    std::uint64_t size = big_endian(header, 4);
    if (size == 1) size = big_endian(header + 8, 8);
    if (size == 0) size = file_size - position;  // "to the end of the file"
    if (size < 8) return boxes;                  // trailing bytes that are no box
    boxes.has_index |= type == "moov";
    boxes.cut_off |= size > file_size - position;
    if (boxes.cut_off) return boxes;
    position += size;
  }
  return boxes;
}

}  // namespace likeness
