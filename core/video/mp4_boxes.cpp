// Walk over the outermost boxes of an MP4 file: see mp4_boxes.h.
#include "core/video/mp4_boxes.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

#include "core/video/box_walk.h"

namespace likeness {
namespace {

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
  bool fragmented = false;
  for (std::uint64_t position = 0;;) {
    const auto box = read_box(file, position, file_size);
    if (!box) return boxes;
    if (position == 0) boxes.is_mp4 = may_come_first(box->type);
    if (!boxes.is_mp4 || box->end < box->begin) return boxes;  // trailing bytes that are not a box
    boxes.has_index |= box->type == "moov";
    fragmented |= box->type == "moof";
    boxes.cut_off |= box->end > file_size;
    boxes.cut_fragment |= boxes.cut_off && fragmented && (box->type == "moof" || box->type == "mdat");
    if (boxes.cut_off) return boxes;
    position = box->end;
  }
}

}  // namespace likeness
