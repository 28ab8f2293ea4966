// Empty cells of the canonical face instead of the posed one: Li 2022 keeps a voxel grid of the canonical
// face and looks samples up where the head model's deformation maps them, assuming that what the field adds
// to that deformation - a learnt residual there, the ambient slice here - does not move density across cells.
// `likeness study --tables occupancy` measures how true that is.
//
// One grid then stands for all expressions without being the union of their surfaces.
#pragma once

#include <span>
#include <vector>

#include "core/field/field.h"
#include "core/render/rays.h"
#include "core/train/volumes.h"

namespace likeness {

struct CanonicalState {
  int resolution = 0;
  std::vector<float> density;         // (z, y, x) decaying maximum, per cube side; starts as occupied
  OccupancyGrid occupancy;            // cells over the threshold, and their neighbours
  std::vector<std::uint8_t> opacity;  // as in FieldPart; empty until the first samples
};
CanonicalState make_canonical_state(int resolution);

// looks: places in the canonical face's unit cube with the density found there, the same in number.
void add_cell_samples(CanonicalState& state, const FieldInputs& looks, std::span<const float> sigma);

// For a march: posed is the head's volume, whose `kept` cells are never culled. Refers to its arguments.
CanonicalCells canonical_cells(const CanonicalState& state, const Volume& posed,
                               std::span<const WarpLattice> lattices);

}  // namespace likeness
