// A folder of photographs as a clip: one picture a second, in the order of names, as phones number them.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

// .jpg, .jpeg, .png, .tif, .tiff, .webp, by name; at least three.
Result<std::vector<std::filesystem::path>> list_photos(const std::filesystem::path& folder);

// RGB, upright by its orientation tag. Refuses a truncated file.
Result<Image8> read_photo(const std::filesystem::path& path);

// One channel, of an RGB picture: as a film's coded luma weighs the colours.
Image8 luma_of_photo(const Image8& rgb);

// One hash of the names and contents of all photographs.
Result<std::string> hash_photos(const std::filesystem::path& folder);

// The error for a photograph whose size differs from the first one's in its folder.
Error other_size_error(const std::filesystem::path& path, const Image8& photo, int width, int height);

}  // namespace likeness
