// Updating the cells of a grid from samples (occupancy_refresh.h), for processor and device. Plain C++17.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/train/random_stream.h"

namespace likeness {

constexpr float kCellDecay = 0.9f;      // per update
constexpr float kCellThreshold = 7.0f;  // density per cube side; through one of 96 cells an opacity of 0.07
constexpr std::uint64_t kCellStream = 0xcccull;

// A random place in a cell, and the view whose condition is used.
struct CellSample {
  float place[3];  // unit cube
  std::int32_t view;

  // cell: (z, y, x) index in a grid of n an axis; item: its number among the sampled cells.
  LIKENESS_HOST_DEVICE CellSample(std::uint32_t cell, int n, std::uint32_t views, std::uint64_t seed,
                                  std::uint64_t step, std::size_t item) {
    RandomStream random(seed ^ kCellStream, step, item);
    const int at[3] = {int(cell) % n, int(cell) / n % n, int(cell) / (n * n)};
    for (int a = 0; a < 3; ++a) place[a] = (float(at[a]) + random.uniform()) / float(n);
    view = std::int32_t(random.below(views));
  }
};

LIKENESS_HOST_DEVICE inline float decayed_density(float before, float found) {
  const float kept = before * kCellDecay;
  return kept < found ? found : kept;
}

// FieldPart::opacity of a cell.
LIKENESS_HOST_DEVICE inline std::uint8_t cell_opacity(float density, int n) {
  return std::uint8_t(255.5f * (1 - expf(-density / float(n))));
}

}  // namespace likeness
