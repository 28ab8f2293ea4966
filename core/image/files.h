// Pictures in and out of files (OpenImageIO). Written whole or not at all.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

Result<Image8> read_image(const std::filesystem::path& path);  // 1, 3 or 4 channels as stored, 16 bit reduced to 8
Result<void> write_image(const std::filesystem::path& path, const Image8& image);  // format by extension

}  // namespace likeness
