// The lower end of a torso that the pictures cut off. A body sways and a camera draws back: other pictures
// show some rows that no training picture does, and there the torso goes on as it is at its hem rather than
// end in mid-air.
#pragma once

#include <optional>

#include "core/render/avatar.h"
#include "core/train/train.h"

namespace likeness {

// How far below the hem the torso goes on, m.
inline constexpr float kBelowHem = 0.08f;

// Below it lies what none of the clip's own pictures shows, but for the few that reach deepest; nullopt where
// none shows the torso's place.
std::optional<TorsoHem> find_hem(const TrainingSet& set, const FieldCube& torso);

// Occupied cells down to kBelowHem below the hem, as those at the hem are.
void extend_below(const TorsoHem& hem, FieldPart& torso);

}  // namespace likeness
