// One frame of the torso: robust Gauss-Newton over its in-plane motion and its deformation, against a
// template.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/scene/torso_warp.h"
#include "core/track/torso/torso_picture.h"
#include "core/track/torso/torso_state.h"

namespace likeness {

// What may change besides the motion.
enum class TorsoFreedom { rigid, nodes, modes };

// Mean absolute difference of relief, grey levels, at the start of the last iteration; 1e9 if too little is
// seen. With TorsoFreedom::nodes the grid is kept smooth; with modes the shape is pulled towards the training
// frames' spread.
double align_torso(const std::vector<TorsoPixel>& pixels, const TorsoView& view, const Vec2d& pivot,
                   const TorsoGrid& grid, const TorsoModes* modes, TorsoFreedom freedom, int iterations,
                   TorsoState* state);

// Sum over pixels of J^T J for displacements of the nodes, with the template itself as the picture, plus the
// smoothness: the metric of deformations, (2P, 2P).
Eigen::MatrixXd picture_metric(const std::vector<TorsoPixel>& pixels, const TorsoView& view,
                               const TorsoGrid& grid);

}  // namespace likeness
