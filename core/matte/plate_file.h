// plate.json: what is known of the plate beside its picture.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/camera/camera.h"

namespace likeness {

// The contents of plate.json beside plate.png. A missing file means no plate.
struct PlateInfo {
  double coverage = 0;
  std::vector<int> frames;
  std::optional<Camera>
      camera{};  // of a mosaic (core/camera/mosaic.h); nullopt: the plate is the frames' own picture
};
Result<void> write_plate_info(const std::filesystem::path& path, const PlateInfo& info);
Result<PlateInfo> read_plate_info(const std::filesystem::path& path);

}  // namespace likeness
