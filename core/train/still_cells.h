// Where no expression moves anything: hair, skull, ears, back of the neck. A field that may use psi there
// memorises the track's errors, since a bowed head is usually also speaking, and renders hair elsewhere when
// the same pose occurs with another expression.
#pragma once

#include <cstdint>
#include <span>

#include "core/head/pose_head.h"
#include "core/render/avatar.h"
#include "core/render/rays.h"

namespace likeness {

struct StillOptions {
  float moved = 0.002f;  // m by which an articulation must displace a vertex to count
  float reach = 0.012f;  // m around a moved vertex where the field may follow the expression
};

// Cells of the head's cube farther than `reach` from every vertex that an articulation moves away from the
// mean of them.
OccupancyGrid still_cells(const HeadModel& model, const HeadShape& shape,
                          std::span<const Articulation> articulations, const FieldCube& cube, int resolution,
                          const StillOptions& options = {});

// Removes the cells in which an attribute acts: there the field must be conditioned on its amount.
void clear_region(const AttributeRegion& region, const FieldCube& cube, OccupancyGrid& still);

// Samples in still cells get the condition of a random view, without its code, so that the field learns to
// give the same under all of them. Rendering then needs no condition there. view of the samples: row of
// conditions, v or v + views. Samples of views beyond the first `own` are left unchanged: without their code,
// the colours of their light would be learnt.
void shuffle_conditions(const OccupancyGrid& still, std::size_t views, std::size_t own, std::uint64_t seed,
                        std::uint64_t step, FieldSamples& samples);

}  // namespace likeness
