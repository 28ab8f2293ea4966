// See stage_inputs.h.
#include "core/project/stage_inputs.h"

#include <utility>

namespace likeness {

StageInputs stage_inputs(const ProjectOptions& options) {
  const SharedChoices& shared = options.shared;
  StageInputs inputs{
      .import = {.video = shared.video,
                 .landmark_model = shared.landmark_model,
                 .person_network = shared.person_network,
                 .camera = options.align.camera,
                 .choices = options.import},
      .align = {.video = shared.video,
                .landmark_model = shared.landmark_model,
                .person_network = shared.person_network,
                .seed = shared.seed,
                .split = options.import.split,
                .sides = options.import.sides,
                .choices = options.align},
      .fit = {.video = shared.video,
              .head_model = shared.head_model,
              .landmark_model = shared.landmark_model,
              .choices = options.fit},
      .matte = {.head_model = shared.head_model,
                .person_network = shared.person_network,
                .seed = shared.seed,
                .choices = options.matte},
      .train = {.head_model = shared.head_model, .seed = shared.seed, .choices = options.train}};
  inputs.fit.choices.refits = merged_spans(std::move(inputs.fit.choices.refits));
  return inputs;
}

}  // namespace likeness
