// Where no expression moves anything: hair, skull, ears, back of the neck. A field that may use psi there
// learns the track's errors by heart, since a bowed head usually speaks, too, and draws hair elsewhere when
// another expression meets the same pose.
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

// Takes out the cells in which an attribute acts: there the field must be told its amount.
void clear_region(const AttributeRegion& region, const FieldCube& cube, OccupancyGrid& still);

// Samples in still cells get the condition of a random view, without its code, so that the field learns to
// give the same under all of them. What is learnt there needs no condition when a picture is rendered.
// view of the samples: row of conditions, v or v + views. Those of a view beyond the first `own` stay as they
// are: without its code the colours of its light would be learnt.
void shuffle_conditions(const OccupancyGrid& still, std::size_t views, std::size_t own, std::uint64_t seed,
                        std::uint64_t step, FieldSamples& samples);

}  // namespace likeness
