// The matte stage's view of the room behind a moving camera: learnt from its rough mattes, kept in the
// project as room.bin, and shown behind any frame.
#pragma once

#include <cstdint>

#include "core/matte/room_behind.h"
#include "core/project/project.h"
#include "core/project/project_views.h"

namespace likeness {

// Refers to its arguments, all but the seed. What it returns does not.
LearnRoom room_learner(const Project& project, std::uint64_t seed, const TrackedCapture& read);

}  // namespace likeness
