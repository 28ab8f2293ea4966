// The state of a training run: its fields, codes and conditions, and how far it has come.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/field/adam.h"
#include "core/render/avatar.h"
#include "core/render/rays.h"
#include "core/scene/avatar_pose.h"
#include "core/train/canonical_cells.h"
#include "core/train/occupancy_refresh.h"
#include "core/train/ray_batch.h"
#include "core/train/schedule.h"
#include "core/train/train.h"
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

TrainingState make_training_state(const TrainingSet& set, const TrainOptions& options,
                                  const ConditionMap& map, const Volumes& volumes);

// The conditions of the views in these poses, and their spread.
void set_conditions(TrainingState& state, const ConditionMap& map, std::span<const AvatarPose> poses,
                    std::span<const AttributeRegion> attributes);

}  // namespace likeness
