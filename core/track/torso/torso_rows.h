// The residual of one template pixel in one frame, and the prior of a smooth grid: shared by the alignment of
// a frame and by the fit of the modes to all frames.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/scene/torso_warp.h"
#include "core/track/torso/torso_picture.h"
#include "core/track/torso/torso_state.h"

namespace likeness {

inline constexpr double kTorsoHuber = 20;        // grey levels
inline constexpr double kTorsoShapeNoise = 4.5;  // grey levels: strength of the pull towards the usual shape
inline constexpr double kTorsoPixelsMeant = 4000;  // priors are stated for this many pixels
inline constexpr double kTorsoMotionPrior = 1;     // tiny: keeps the system regular
// Pull towards the head's distance: a torso comes nearer mostly because the camera does. Little
// against what cloth with a pattern says, grey levels^2 / m^2.
inline constexpr double kTorsoDepthPrior = 3e7;
inline constexpr int kTorsoRigid = 4;  // angle, shift, depth

// The frame's relief (core/track/torso/torso_picture.h) at a canonical point minus the template's, and its
// derivatives.
struct TorsoRow {
  double residual = 0;                       // grey levels
  double weight = 0;                         // the template's, less where the residual is large (Huber)
  double cost = 0;                           // Huber's, grey levels^2
  Eigen::Matrix<double, kTorsoRigid, 1> by;  // grey levels per rad, m, m, m
  Vec2d by_place = Vec2d::Zero();            // grey levels per m that the point is displaced
  GridPlace at;                              // of the canonical point

  // Per m of the x (even) and y (odd) displacement of node at.node[k / 2].
  double by_node(int k) const { return double(at.weight[std::size_t(k / 2)]) * by_place[k % 2]; }
  int node_index(int k) const { return 2 * at.node[std::size_t(k / 2)] + k % 2; }
  // Per unit of a mode, (rows, columns, 2), m.
  double by_mode(const std::vector<float>& mode) const {
    double sum = 0;
    for (int k = 0; k < 8; ++k) sum += by_node(k) * mode[std::size_t(node_index(k))];
    return sum;
  }
};

// False if the pixel has no weight, is not seen, or is hidden by the head. `pose` is
// motion_pose(state.motion).
bool torso_row(const TorsoPixel& pixel, const TorsoView& view, const Pose& pose, const Vec2d& pivot,
               const TorsoGrid& grid, const TorsoState& state, TorsoRow* row);

// 1/2 stiffness times the sum of squared differences between neighbouring nodes of a field, and weakly
// between each and rest: added to the Hessian's block and the gradient's from `first` on, and to the cost, if
// not null. stiffness: grey levels^2 / m^2; at: the field, (2P), m; null: only the Hessian.
void add_smoothness(const TorsoGrid& grid, double stiffness, const Eigen::VectorXd* at, int first,
                    Eigen::MatrixXd* hessian, Eigen::VectorXd* gradient, double* cost);

}  // namespace likeness
