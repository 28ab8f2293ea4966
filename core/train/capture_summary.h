// What a training set says about its person as a whole: the neutral face, the typical view, the range of each
// action, and the avatar made up of these.
#pragma once

#include <vector>

#include "core/train/train.h"

namespace likeness {

// The face at rest: the set's calibrated neutral; without one, the median of each coefficient over the views.
Articulation typical_articulation(const TrainingSet& set);

// The view whose head pose is nearest to all others' (medoid; 10 degrees count as 3 cm).
std::size_t typical_view(const TrainingSet& set);

// Everything in an avatar that follows from the capture: the fields, and facts about the training, are left
// empty. warp_cell, neck: as in Avatar.
Avatar capture_avatar(const TrainingSet& set, const ConditionMap& map, float warp_cell, const NeckZone& neck);

// Per named action of the model, what the views show of it.
std::vector<ActionRange> action_ranges(const TrainingSet& set);

}  // namespace likeness
