// Which sides of the head the first clip shows, so that further clips determine only what it never showed.
#pragma once

#include <cstdint>

#include "core/head/pose_head.h"
#include "core/render/avatar.h"
#include "core/render/rays.h"
#include "core/train/train.h"

namespace likeness {

// Cells of the head's cube that a camera of the avatar's own views looked at: the head is treated as a sphere
// about the middle of its mesh, of which a view shows what faces it within about 65 degrees.
OccupancyGrid sides_seen(const TrainingSet& set, const HeadShape& shape, const FieldCube& head);

// Half of a further clip's samples on sides that were not seen get the code of zero: nothing else determines
// how the avatar looks there. On the other sides they keep their view's code, and with it their light. own,
// views: as in shuffle_conditions (core/train/still_cells.h). samples: of the head's unit cube.
void drop_codes_on_new_sides(const OccupancyGrid& seen, std::size_t views, std::size_t own,
                             std::uint64_t seed, std::uint64_t step, FieldSamples& samples);

}  // namespace likeness
