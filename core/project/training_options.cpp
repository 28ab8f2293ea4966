// See training_options.h.
#include "core/project/training_options.h"

#include "core/base/files.h"
#include "core/head/pose_head.h"

namespace likeness {

TrainOptions training_options(const TrainInputs& inputs) {
  TrainOptions training;
  training.budget_s = inputs.budget_s;
  training.steps = inputs.steps;
  training.seed = inputs.seed;
  training.checkpoint_every_s = inputs.checkpoint_every_s;
  training.mode = inputs.mode.value_or(kDefaultMode);
  training.refine_track = inputs.refine_track;
  training.landmark_weight = inputs.landmark_loss;
  training.use_latent = inputs.use_latent;
  training.use_occupancy = inputs.use_occupancy;
  return training;
}

ChosenParts take_parts(const Project& project, TrainingSet& set, TrainOptions& options) {
  const TrainInputs o = stage_inputs(project.options).train;
  const AskedParts asked{.mode = o.mode,
                         .no_latent = !o.use_latent,
                         .no_occupancy = !o.use_occupancy,
                         .refine_track = o.refine_track,
                         .landmark_weight = o.landmark_loss};
  CaptureMeasures measures = measure_capture(set, shape_head(set.model, set.person));
  measures.has_room = path_exists(room_path(project));
  ChosenParts chosen = choose_parts(measures, asked);
  apply_parts(chosen, set, options);
  return chosen;
}

}  // namespace likeness
