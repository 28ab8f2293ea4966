// A folder of photographs as a clip: one picture a second, in the order of names, as phones and people number
// them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

// .jpg, .jpeg, .png, .tif, .tiff, .webp, and where OpenImageIO reads them .heic, .heif and .avif, by name
// (core/base/natural_order.h); at least three. Of names that are there both as HEIF and in another kind,
// those of the kind that has more pictures.
Result<std::vector<std::filesystem::path>> list_photos(const std::filesystem::path& folder);

// What else in the folder is a picture by its name, but cannot be read, counted by kind, and what to do; then
// how many are left out because they are there in another kind: sentences; empty where there is nothing.
std::string unread_pictures(const std::filesystem::path& folder);

// RGB, upright by its orientation tag, over the backdrop where it is transparent (alpha.h). alpha: becomes
// what it hides something by, or empty; may be null. Refuses a truncated file.
Result<Image8> read_photo(const std::filesystem::path& path, Image8* alpha = nullptr);

// One channel, of an RGB picture: as a film's coded luma weighs the colours.
Image8 luma_of_photo(const Image8& rgb);

// One hash of the names and contents of all photographs.
Result<std::string> hash_photos(const std::filesystem::path& folder);

// Whether a folder's others are read without the one that this is said of: not where the disk fails, nor
// where more than half cannot be read or are of another size. count: of those, this one among them.
bool may_leave_out(const Error& error, std::size_t count, std::size_t all);
// What to tell of those that were left out.
Error left_out_error(const std::vector<Error>& left_out, std::size_t all);

// The error for a photograph whose size differs from the first one's in its folder.
Error other_size_error(const std::filesystem::path& path, const Image8& photo, int width, int height);

}  // namespace likeness
