// Pictures whose pixels are measurements, not colours: read without conversion to 8 bits.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"

namespace likeness {

struct NumberPicture {
  int width = 0, height = 0;
  int bits = 0;               // of a number in the file
  bool whole = false;         // they are whole counts, 0 .. 2^bits - 1; otherwise floating point
  std::vector<float> values;  // (height, width) as stored in the file, origin top left
};

// From one channel; of pictures with three or four, the first. PNG, TIFF, EXR.
Result<NumberPicture> read_numbers(const std::filesystem::path& path);

}  // namespace likeness
