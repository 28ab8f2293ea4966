// Learning which cells are occupied.
#include "core/train/occupancy_refresh.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/train/cell_math.h"

namespace likeness {
namespace {

constexpr float kInitial = 10.0f;  // occupied until some updates have found nothing

}  // namespace

OccupancyState make_occupancy_state(const Volume& volume) {
  OccupancyState state;
  const int n = volume.allowed.resolution;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        if (volume.allowed.occupied(x, y, z)) state.cells.push_back(std::uint32_t((z * n + y) * n + x));
  state.density.assign(state.cells.size(), kInitial);
  return state;
}

Result<void> refresh_occupancy(OccupancyState& state, int resolution, const float* conditions,
                               std::size_t views, const std::function<void(FieldSamples&)>& to_canonical,
                               const Densities& densities, std::uint64_t seed, std::uint64_t step) {
  const int n = resolution;
  const std::size_t count = state.cells.size();
  if (count == 0) return {};
  FieldSamples samples;
  samples.resize(count);
  parallel_ranges(count, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const CellSample look(state.cells[i], n, std::uint32_t(views), seed, step, i);
      samples.x[i] = look.place[0], samples.y[i] = look.place[1], samples.z[i] = look.place[2];
      samples.view[i] = look.view;
    }
  });
  to_canonical(samples);
  std::vector<float> sigma;
  if (auto done = densities(samples.inputs(conditions, nullptr), sigma); !done) return done;
  for (std::size_t i = 0; i < count; ++i) state.density[i] = decayed_density(state.density[i], sigma[i]);
  return {};
}

OccupancyGrid occupancy_bits(const OccupancyState& state, const Volume& volume) {
  const int n = volume.allowed.resolution;
  OccupancyGrid grid = volume.kept;
  for (std::size_t i = 0; i < state.cells.size(); ++i) {
    if (state.density[i] <= kCellThreshold) continue;
    const int cell = int(state.cells[i]), cx = cell % n, cy = cell / n % n, cz = cell / (n * n);
    for (int z = std::max(0, cz - 1); z <= std::min(n - 1, cz + 1); ++z)
      for (int y = std::max(0, cy - 1); y <= std::min(n - 1, cy + 1); ++y)
        for (int x = std::max(0, cx - 1); x <= std::min(n - 1, cx + 1); ++x)
          set_occupied(grid, x, y, z, true);
  }
  for (std::size_t b = 0; b < grid.bits.size(); ++b) grid.bits[b] &= volume.allowed.bits[b];
  return grid;
}

std::vector<std::uint8_t> cell_opacities(const OccupancyState& state, const Volume& volume) {
  const int n = volume.allowed.resolution;
  std::vector<std::uint8_t> opacity(std::size_t(n) * n * n, 0);
  parallel_ranges(state.cells.size(), 16384, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) opacity[state.cells[i]] = cell_opacity(state.density[i], n);
  });
  return opacity;
}

}  // namespace likeness
