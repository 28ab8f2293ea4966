// Which of the allowed cells hold density, learnt along with the field: a decaying maximum of the density
// seen in a cell over random points and training expressions.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/result.h"
#include "core/render/avatar.h"
#include "core/render/rays.h"
#include "core/train/volumes.h"

namespace likeness {

struct OccupancyState {
  std::vector<std::uint32_t> cells;  // the allowed cells, (z, y, x) index
  std::vector<float> density;        // (cells) decaying maximum, per cube side; starts as occupied
};
OccupancyState make_occupancy_state(const Volume& volume);

// Samples every allowed cell once, at a random point under a random one of `views` rows of `conditions`;
// to_canonical maps the samples to canonical space, densities evaluates the field there. resolution: of the
// grid.
using Densities = std::function<Result<void>(const FieldInputs&, std::vector<float>& sigma)>;
Result<void> refresh_occupancy(OccupancyState& state, int resolution, const float* conditions,
                               std::size_t views, const std::function<void(FieldSamples&)>& to_canonical,
                               const Densities& densities, std::uint64_t seed, std::uint64_t step);

// Cells over the threshold, their neighbours, and the cells that are always kept, within the allowed ones.
OccupancyGrid occupancy_bits(const OccupancyState& state, const Volume& volume);

// FieldPart::opacity of these densities.
std::vector<std::uint8_t> cell_opacities(const OccupancyState& state, const Volume& volume);

}  // namespace likeness
