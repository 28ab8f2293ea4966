// Learning the low-dimensional condition psi of the ambient slice from the articulations of the training
// track.
#pragma once

#include <span>

#include "core/head/pose_head.h"
#include "core/render/avatar.h"

namespace likeness {

struct ConditionOptions {
  int components = 6;  // of expression and jaw; more overfit (measured: 16 whitened ones lose 1 dB)
  bool gaze = true;    // two more: mean yaw and pitch of the eyes, if the track has them
};
// Below this variation of the eyes' mean turn about an axis (rms, rad) the field is not conditioned on it.
inline constexpr double kSmallestGaze = 0.01;
inline constexpr ConditionOptions kNoCondition{.components = 0, .gaze = false};  // psi is empty

// Principal components in the metric of the vertex motion that the articulation causes on the face, so that
// coefficients which cancel on the mesh cancel in psi. Plain, not whitened: the first component has standard
// deviation 0.5, the others keep their proportion. Components without motion are left out, so psi may be
// empty. Clamped to the range that the articulations span.
ConditionMap learn_condition_map(const HeadModel& model, const HeadShape& shape,
                                 std::span<const Articulation> articulations,
                                 const ConditionOptions& options = {});

// How much a track's faces differ from each other: root mean squares about the mean.
struct ArticulationSpread {
  double face = 0;                      // m, also over the face's vertices: motion by expression and jaw
  double gaze_pitch = 0, gaze_yaw = 0;  // rad, mean of both eyes
};
ArticulationSpread articulation_spread(const HeadModel& model, const HeadShape& shape,
                                       std::span<const Articulation> articulations);

}  // namespace likeness
