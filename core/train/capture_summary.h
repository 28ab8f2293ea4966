// What a training set says about its person as a whole: the neutral face, the typical view, the range of each
// action.
#pragma once

#include <vector>

#include "core/train/train.h"

namespace likeness {

// Median of each coefficient over the views: the face at rest.
Articulation typical_articulation(const TrainingSet& set);

// The view whose head pose is nearest to all others' (medoid; 10 degrees count as 3 cm).
std::size_t typical_view(const TrainingSet& set);

// Per named action of the model, its 2nd and 98th percentile over the views, from a ridge least-squares solve
// of each view's expression and jaw in the actions.
std::vector<ActionRange> action_ranges(const TrainingSet& set);

}  // namespace likeness
