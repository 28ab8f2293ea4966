// Pictures in and out of files (OpenImageIO). Written whole or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

struct ImageWriteOptions {
  int png_level = 4;      // zlib's 0..9; more is smaller and slower
  int jpeg_quality = 95;  // 1..100
  // Keyword and UTF-8 text, for PNG only: iTXt chunks. A keyword has 1 to 79 Latin letters.
  std::vector<std::pair<std::string, std::string>> texts = {};
};

// 1, 3 or 4 channels as stored, alpha straight, 16 bit reduced to 8. A truncated picture is refused. An
// orientation tag is not applied: pixels are as stored in the file, as COLMAP sees them.
Result<Image8> read_image(const std::filesystem::path& path);
// HEIF's two, HEIC and AVIF: whether the installed OpenImageIO has their reader.
bool reads_heif();
int image_orientation(const std::filesystem::path& path);  // the tag's 1 (upright) to 8; 1 if there is none
Result<void> write_image(const std::filesystem::path& path, const Image8& image,
                         const ImageWriteOptions& options = {});  // format by extension

}  // namespace likeness
