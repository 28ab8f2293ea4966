// The outermost elements of a Matroska or WebM file (RFC 9559): shows whether a file is truncated, whatever
// the demuxer reports.
#pragma once

#include <filesystem>

namespace likeness {

// The file ends before its segment does, and before what follows the pictures begins. Of a segment that
// states no size, as live recordings are written, nobody can tell: false, as for any other file.
bool is_cut_matroska(const std::filesystem::path& path);

}  // namespace likeness
