// The folder in which colmap works on one clip: emptied if its contents belong to other inputs, kept
// otherwise.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

// Prepares the folder for inputs with this hash. Removes only what this library writes there.
Result<void> prepare_work_folder(const std::filesystem::path& work, const std::string& inputs_hash);

bool pictures_ready(const std::filesystem::path& work);
Result<void> mark_pictures_ready(const std::filesystem::path& work);

// Moves pictures that were made ready in another work folder of the same inputs; false: there are none such.
bool take_pictures(const std::filesystem::path& from, const std::string& inputs_hash,
                   const std::filesystem::path& work);

// Writes images/NAME reduced to `width` and masks/NAME.png. mask: 255 = ignore, at the source's size, or
// empty.
Result<void> write_picture(const std::filesystem::path& work, const std::string& name, const Image8& rgb,
                           const Image8& mask, int width);

// Height of a picture reduced to `width`.
int reduced_height(int width, int height, int reduced_width);

}  // namespace likeness
