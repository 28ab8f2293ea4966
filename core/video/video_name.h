// Which files are taken for films, by their names alone.
#pragma once

#include <filesystem>

namespace likeness {

// By its ending, in letters of either case.
bool is_video_name(const std::filesystem::path& path);

}  // namespace likeness
