// Modes of a torso's deformation over the training frames: principal components in the picture's metric.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/scene/torso_warp.h"

namespace likeness {

// displacements: (N) frames of (rows, columns, 2), m. metric: (2P, 2P), positive definite. Rotation about the
// pivot and translation, which belong to the pose, are removed from the modes, which are scaled to one
// standard deviation. Fewer than kMinimumTorsoFrames: no modes, a rigid torso.
inline constexpr int kMinimumTorsoFrames = 20;
TorsoModes learn_torso_modes(const TorsoGrid& grid, const std::vector<std::vector<float>>& displacements,
                             const Eigen::MatrixXd& metric, const Vec2d& pivot);

}  // namespace likeness
