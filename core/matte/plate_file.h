// plate.json: what is known of the plate beside its picture.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"

namespace likeness {

// The contents of plate.json beside plate.png. A missing file means no plate.
struct PlateInfo {
  double coverage = 0;
  std::vector<int> frames;
};
Result<void> write_plate_info(const std::filesystem::path& path, const PlateInfo& info);
Result<PlateInfo> read_plate_info(const std::filesystem::path& path);

}  // namespace likeness
