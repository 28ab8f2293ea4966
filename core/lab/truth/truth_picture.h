// A picture that a demo wrote beside its film.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

// channels: as the demo writes it, 3 of a wall or 1 of a mask; a picture with others is refused.
Result<Image8> read_truth_picture(const std::filesystem::path& path, int channels);

}  // namespace likeness
