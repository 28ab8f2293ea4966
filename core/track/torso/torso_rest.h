// Where a torso may be taken to rest: while somebody walks round a person who holds still.
#pragma once

#include <vector>

#include "core/track/torso/torso.h"

namespace likeness {

// The number of the stretch that a frame belongs to, from 0 on; -1: to none. A stretch is at least a few
// frames in which the camera goes some way while the head stays where it is in the world: whoever holds the
// head still holds the torso still. What the pictures say of the torso there is mostly the parallax of a
// template whose depth is a guess. Training frames alone decide whether; a frame whose own head plainly moves
// belongs to none.
std::vector<int> resting_torso(const std::vector<TorsoFrame>& frames);

}  // namespace likeness
