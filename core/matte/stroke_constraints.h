// Strokes as hard constraints of a frame's cut.
#pragma once

#include <opencv2/core.hpp>

#include "core/matte/person_prior.h"
#include "core/matte/strokes.h"

namespace likeness {

// Makes pixels that strokes mark as person certain, and those marked as background impossible. The cover is
// of the prior's size; an empty one changes nothing.
void constrain_prior(PersonPrior& prior, const StrokeCover& cover);

// Holds a finished cut (8U, 255 = person) to its strokes. An empty cover changes nothing.
void hold_cut(cv::Mat& person, const StrokeCover& cover);

}  // namespace likeness
