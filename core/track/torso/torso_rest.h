// Where a torso may be assumed to rest: while the camera is walked round a person who holds still.
#pragma once

#include <vector>

#include "core/track/torso/torso_frame.h"

namespace likeness {

// The number of the stretch that a frame belongs to, from 0 on; -1: to none. A stretch is at least a few
// frames in which the camera travels while the head stays in place in the world: a still head implies a still
// torso. What the pictures show of the torso there is mostly parallax of a template whose depth is a guess.
// Only training frames decide; a frame whose own head plainly moves belongs to none.
std::vector<int> resting_torso(const std::vector<TorsoFrame>& frames);

}  // namespace likeness
