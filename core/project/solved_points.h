// The points of the room that the solve of a moving camera found: what its path hangs on.
#pragma once

#include <vector>

#include "core/base/linalg.h"
#include "core/base/result.h"
#include "core/project/project.h"
#include "core/scene/track.h"

namespace likeness {

inline constexpr std::size_t kMostSolvedPoints = 6000;

// World frame, m; evenly thinned to kMostSolvedPoints. Those seen in fewer than three pictures, or badly, are
// left out. Empty where the camera rests: nothing was solved.
Result<std::vector<Vec3f>> solved_points(const Project& project, const Track& track);

}  // namespace likeness
