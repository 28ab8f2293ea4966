// What is measured of a device, how often and on how much.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace likeness {

struct DeviceBenchOptions {
  std::vector<std::size_t> batches = {131072, 1048576};  // samples
  int rounds = 20;                                       // of each figure; the median counts
  std::size_t ceiling_bytes = std::size_t{256} << 20;    // read and written as much
  int matrix_repeats = 4096;
  std::size_t error_samples = 1024;
  int frame_size = 512;                                       // px a side of the pictures
  int step_rays = 8192, step_views = 64, step_picture = 256;  // of a training's step; px a side
  int look_every = 1;                                         // cell into which a look goes
  std::uint32_t seed = 1;
};

}  // namespace likeness
