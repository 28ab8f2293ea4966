// What must hold of a training set before anything is learnt from it.
#pragma once

#include "core/base/result.h"
#include "core/train/train.h"

namespace likeness {

// Pictures, mattes, plate, cameras and track fit each other and are finite; otherwise which does not, and
// what to do.
Result<void> check_training_set(const TrainingSet& set);

}  // namespace likeness
