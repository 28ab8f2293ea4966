// One step of a training: rays -> samples, then by the backend fields -> compositing -> loss ->
// gradients -> Adam.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/base/result.h"
#include "core/render/backend.h"
#include "core/train/ray_batch.h"
#include "core/train/step_options.h"
#include "core/train/training_state.h"

namespace likeness {

struct StepResult {
  double loss = 0;           // mean squared error over rays and channels
  double landmark_loss = 0;  // lambda L_lmk
  bool finite = true;        // losses and gradients' source; false: nothing was changed
  std::size_t samples = 0;
};

// A learner of the state's fields, which must not be moved.
Result<std::unique_ptr<FieldLearner>> make_learner(Backend& backend, TrainingState& state,
                                                   const StepOptions& options, const TrainingSet& set);

// A step's rays and their samples, cast by the processor into the state's batches; and an update of both
// fields' cells by the learner.
void cast_rays(TrainingState& state, const RaySource& source, const StepOptions& options);
Result<void> refresh_fields(TrainingState& state, FieldLearner& learner, const RaySource& source,
                            std::uint64_t seed);

class RayCaster;  // core/train/cast_rays.h

// If the backend fails, only its own copy of the fields has changed. caster: casts the rays and updates the
// cells on the learner's device; null: the processor does.
Result<StepResult> training_step(TrainingState& state, FieldLearner& learner, const RaySource& source,
                                 const StepOptions& options, RayCaster* caster = nullptr);

}  // namespace likeness
