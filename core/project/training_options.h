// How a project is trained, by its choices.
#pragma once

#include "core/project/project.h"
#include "core/project/stage_inputs.h"
#include "core/train/choose_parts.h"
#include "core/train/train.h"

namespace likeness {

// Where it computes is the run's (TrainingPlace). The parts that are for the capture to decide are the usual
// ones (apply_parts, core/train/choose_parts.h).
TrainOptions training_options(const TrainInputs& inputs);

// Chooses the parts for a set with its pictures, by what it measures and what the project's choices fix, and
// changes set and options to a training with them.
ChosenParts take_parts(const Project& project, TrainingSet& set, TrainOptions& options);

}  // namespace likeness
