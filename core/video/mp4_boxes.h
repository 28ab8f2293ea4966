// The outermost boxes of an MP4 or MOV file: shows whether a file is truncated, whatever the demuxer reports.
#pragma once

#include <filesystem>

namespace likeness {

struct Mp4Boxes {
  bool is_mp4 = false;     // starts with a box typical of such files
  bool has_index = false;  // there is a 'moov' box
  bool cut_off = false;    // a box claims more bytes than the file has
  bool cut_fragment =
      false;  // that box is one of the fragments that a film is recorded in: pictures are lost
};

Mp4Boxes scan_mp4_boxes(const std::filesystem::path& path);  // for an unreadable file: all false

}  // namespace likeness
