// The state of a training run, and one step of it: rays -> samples, then by the backend fields -> compositing
// -> loss -> gradients -> Adam.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/field/adam.h"
#include "core/render/backend.h"
#include "core/render/rays.h"
#include "core/train/canonical_cells.h"
#include "core/train/occupancy_refresh.h"
#include "core/train/ray_batch.h"
#include "core/train/schedule.h"
#include "core/train/volumes.h"

namespace likeness {

// One field in training. What must survive an interruption: field, adam, occupancy and learnt.
struct TrainedField {
  Volume volume;
  FieldPart part;
  AdamState adam;
  OccupancyState learnt;
  std::optional<CanonicalState> canonical;  // if training looks empty cells up in the canonical face
};

struct TrainingState {
  TrainedField head;
  std::optional<TrainedField> torso;
  std::vector<float>
      codes;  // (2 views, L): the views' latent codes, then as many zero rows for dropped codes
  ArrayAdamState codes_adam;      // of the first half
  std::vector<float> conditions;  // (2 views, K), the second half repeats the first, blurred in each step
  std::vector<float> deviations;  // (K) of psi over the views
  std::vector<Eigen::VectorXd> corrections;  // of the views' tracks; empty: none
  int refinements = 0;                       // made so far
  std::uint64_t step = 0;
  double seconds = 0;       // spent in training so far, earlier runs included
  double pass_seconds = 0;  // of them, in corrections of tracks, which do not count against the budget
  Schedule schedule;
  // Scratch.
  RayBatch rays;
  SampleBatch samples;
};

// Whether everything learnt is finite. The loss does not show it: max() hides a layer's NaN.
bool is_finite(const TrainingState& state);

inline constexpr int kTrainingSamples = 16;  // of a ray, at most

struct StepOptions {
  int rays = 8192;
  std::uint64_t seed = 0;
  bool use_latent = true, use_occupancy = true;
  float even_samples = kEvenShare;
  double landmark_weight = 0;  // lambda of the landmark loss
};

struct StepResult {
  double loss = 0;           // mean squared error over rays and channels
  double landmark_loss = 0;  // lambda L_lmk
  bool finite = true;        // losses and gradients' source; false: nothing was changed
  std::size_t samples = 0;
};

TrainingState make_training_state(const TrainingSet& set, const TrainOptions& options,
                                  const ConditionMap& map, const Volumes& volumes);

// A learner of the state's fields, which must not be moved.
Result<std::unique_ptr<FieldLearner>> make_learner(Backend& backend, TrainingState& state,
                                                   const StepOptions& options, const TrainingSet& set);

// The conditions of the views in these poses, and their spread.
void set_conditions(TrainingState& state, const ConditionMap& map, std::span<const AvatarPose> poses,
                    std::span<const AttributeRegion> attributes);

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
