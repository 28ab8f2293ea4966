// The frozen evaluation regions of a held-out frame, read back for the pictures that are scored.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/image/image.h"

namespace likeness {

// Where a frame is scored. One channel at the picture's size, 255 inside.
struct Regions {
  Image8 person, head, face;
};

// The filmed part of FOLDER/000360.png, in source pixels: red person, green head, blue face.
Result<Regions> read_regions(const std::filesystem::path& folder, const Capture& capture, int frame);

}  // namespace likeness
