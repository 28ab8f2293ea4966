// All that a project's training learns from: its own views and those of its further clips.
#pragma once

#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/project/project.h"
#include "core/train/train.h"

namespace likeness {

// Training views (used frames with a good or weak track that were not left out), plate and person of a
// project, then the views of further clips. All but the pictures, which load_training_pictures adds.
Result<TrainingSet> load_training_views(const Project& project, const HeadModel& model);
Result<void> load_training_pictures(const Project& project, TrainingSet& set);
Result<TrainingSet> load_training_set(const Project& project, const HeadModel& model);

}  // namespace likeness
