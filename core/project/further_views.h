// What a training sees of a project's further clips (core/project/further_clips.h).
#pragma once

#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/project/project.h"
#include "core/project/seen_views.h"
#include "core/train/train.h"

namespace likeness {

// The further clips' views for training, without their pictures: those of the head alone
// (TrainingView::further_clip). Their pictures are added by load_further_pictures.
Result<void> add_further_views(const Project& project, const HeadModel& model, TrainingSet& set);
Result<void> load_further_pictures(const Project& project, TrainingSet& set);

// From where the further clips' training pictures show the head. None where the avatar is not the one that
// the project would be trained to now: it may not have learnt from them.
SeenViews learnt_further_views(const Project& project);

}  // namespace likeness
