// See stage_inputs.h.
#include "core/project/stage_inputs.h"

namespace likeness {

StageInputs stage_inputs(const ProjectOptions& options) {
  const ProjectOptions& o = options;
  StageInputs inputs;
  inputs.import = {.video = o.video,
                   .landmark_model = o.landmark_model,
                   .size = o.size,
                   .split = o.split,
                   .resting_camera = o.resting_camera};
  inputs.align = {.video = o.video,
                  .landmark_model = o.landmark_model,
                  .seed = o.seed,
                  .resting_camera = o.resting_camera,
                  .lens_mm = o.lens_mm};
  inputs.fit = {.video = o.video,
                .head_model = o.head_model,
                .landmark_model = o.landmark_model,
                .identity = o.identity,
                .displacement = o.displacement,
                .refits = merged_spans(o.refits)};
  inputs.matte = {.head_model = o.head_model, .matting_network = o.matting_network, .seed = o.seed};
  inputs.train = {.head_model = o.head_model,
                  .budget_s = o.budget_s,
                  .steps = o.steps,
                  .seed = o.seed,
                  .checkpoint_every_s = o.checkpoint_every_s,
                  .mode = o.mode,
                  .use_latent = o.use_latent,
                  .use_occupancy = o.use_occupancy,
                  .refine_track = o.refine_track,
                  .landmark_loss = o.landmark_loss,
                  .left_out = o.left_out};
  return inputs;
}

}  // namespace likeness
