// The outermost boxes of an MP4 or MOV file: shows whether a file was cut off, whatever the demuxer makes of
// it.
#pragma once

#include <filesystem>

namespace likeness {

struct Mp4Boxes {
  bool is_mp4 = false;     // starts with a box that such files start with
  bool has_index = false;  // the 'moov' box was met
  bool cut_off = false;    // a box claims more bytes than the file has
};

Mp4Boxes scan_mp4_boxes(const std::filesystem::path& path);  // of an unreadable file: all false

}  // namespace likeness
