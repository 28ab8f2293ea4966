// Folders of pictures that are made beside their destination and moved there when complete.
#pragma once

#include <filesystem>

#include "core/base/result.h"

namespace likeness {

// Makes an empty folder at this path, removing whatever was there.
Result<std::filesystem::path> fresh_folder(const std::filesystem::path& path);

// Puts a finished folder in place of an old one, which is named TARGET.old meanwhile; on a failure the old
// one stays.
Result<void> replace_folder(const std::filesystem::path& finished, const std::filesystem::path& target);

// A run killed between the two renames of replace_folder leaves the former folder under its other name: puts
// it back.
void restore_folder(const std::filesystem::path& target);

}  // namespace likeness
