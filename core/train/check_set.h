// Conditions on a training set before anything is learnt from it.
#pragma once

#include "core/base/result.h"
#include "core/train/train.h"

namespace likeness {

// Checks that pictures, mattes, plate, cameras and track match each other and are finite; the error says
// which does not, and what to do.
Result<void> check_training_set(const TrainingSet& set);

}  // namespace likeness
