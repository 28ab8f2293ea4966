// The shares of the person in all frames: by the mask that the clip itself brings, or else by the person
// network. Internal to the matte stage.
#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/matte/matte_frames.h"

namespace likeness::matting {

// Sets every job's share, steadied by its neighbours in time; those of training frames by no held-out
// picture. Nothing without either. 30 ms a frame on one core.
Result<void> see_persons(const Stage& stage, std::vector<Job>& jobs, const Progress& progress);

}  // namespace likeness::matting
