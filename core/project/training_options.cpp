// See training_options.h.
#include "core/project/training_options.h"

#include "core/base/files.h"
#include "core/head/pose_head.h"
#include "core/project/project_views.h"

namespace likeness {

TrainOptions training_options(const TrainInputs& inputs) {
  TrainOptions training;
  training.schedule.budget_s = inputs.choices.budget_s;
  training.schedule.steps = inputs.choices.steps;
  training.seed = inputs.seed;
  training.schedule.checkpoint_every_s = inputs.choices.checkpoint_every_s;
  training.fields.mode = inputs.choices.mode.value_or(kDefaultMode);
  training.refine_track = inputs.choices.refine_track;
  training.losses.landmark_weight = inputs.choices.landmark_loss;
  training.fields.use_latent = inputs.choices.use_latent;
  training.rays.use_occupancy = inputs.choices.use_occupancy;
  return training;
}

ChosenParts take_parts(const Project& project, TrainingSet& set, TrainOptions& options) {
  const TrainChoices o = stage_inputs(project.options).train.choices;
  const AskedParts asked{.mode = o.mode,
                         .no_latent = !o.use_latent,
                         .no_occupancy = !o.use_occupancy,
                         .no_proxies = !o.use_proxies,
                         .refine_track = o.refine_track,
                         .landmark_weight = o.landmark_loss};
  CaptureMeasures measures = measure_capture(set, shape_head(set.model, set.person));
  measures.has_room = path_exists(room_path(project));
  measures.background_fault = project_background_fault(project);
  ChosenParts chosen = choose_parts(measures, asked);
  apply_parts(chosen, set, options);
  for (AvatarPart& part : chosen.parts)
    if (part.name == "proxies" && part.on && set.proxies.empty())
      part.on = false, part.value = "left to the field",
      part.reason =
          "The clip shows the head from all around, or has too few frames or no mattes to teach it from.";
  return chosen;
}

}  // namespace likeness
