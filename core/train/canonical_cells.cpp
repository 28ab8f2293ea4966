// Sampling the canonical face's cells: see canonical_cells.h.
#include "core/train/canonical_cells.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/scene/warp_lattice.h"
#include "core/train/cell_math.h"

namespace likeness {
namespace {

constexpr float kInitialOccupancy = 10.0f;  // occupied until some samples have found nothing

std::size_t cell_of(int n, float x, float y, float z) {
  const auto along = [n](float at) { return std::size_t(std::clamp(int(at * float(n)), 0, n - 1)); };
  return (along(z) * std::size_t(n) + along(y)) * std::size_t(n) + along(x);
}

// Cells over the threshold and their neighbours: a cell is looked up by its middle, and its contents may be
// mapped to the next.
OccupancyGrid spread_bits(const std::vector<float>& density, int n) {
  OccupancyGrid grid = make_occupancy(n, false);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        if (density[(std::size_t(z) * n + y) * std::size_t(n) + x] <= kCellThreshold) continue;
        for (int w = std::max(0, z - 1); w <= std::min(n - 1, z + 1); ++w)
          for (int v = std::max(0, y - 1); v <= std::min(n - 1, y + 1); ++v)
            for (int u = std::max(0, x - 1); u <= std::min(n - 1, x + 1); ++u)
              set_occupied(grid, u, v, w, true);
      }
  return grid;
}

}  // namespace

CanonicalState make_canonical_state(int resolution) {
  CanonicalState state;
  state.resolution = resolution;
  state.density.assign(std::size_t(resolution) * resolution * resolution, kInitialOccupancy);
  state.occupancy = make_occupancy(resolution, true);
  return state;
}

void add_cell_samples(CanonicalState& state, const FieldInputs& looks, std::span<const float> sigma) {
  LIKENESS_CHECK(looks.count == sigma.size(), "%zu looks and %zu densities", looks.count, sigma.size());
  for (float& density : state.density) density *= kCellDecay;
  for (std::size_t i = 0; i < looks.count; ++i) {
    float& density = state.density[cell_of(state.resolution, looks.x[i], looks.y[i], looks.z[i])];
    density = std::max(density, sigma[i]);
  }
  state.occupancy = spread_bits(state.density, state.resolution);
  state.opacity.resize(state.density.size());
  for (std::size_t i = 0; i < state.density.size(); ++i)
    state.opacity[i] = cell_opacity(state.density[i], state.resolution);
}

CanonicalCells canonical_cells(const CanonicalState& state, const Volume& posed,
                               std::span<const WarpLattice> lattices) {
  return {&state.occupancy, state.opacity, &posed.kept, posed.cube, lattices.data(), lattices.size()};
}

}  // namespace likeness
