// Which files count as films, by their names alone.
#pragma once

#include <filesystem>

namespace likeness {

// By its extension, in either case.
bool is_video_name(const std::filesystem::path& path);

}  // namespace likeness
