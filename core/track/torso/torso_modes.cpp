// With metric W = L L^T, components are taken of X L, X the centred displacements (N, 2P); a component v
// there is the mode L^-T v.
#include "core/track/torso/torso_modes.h"

#include <cmath>

#include "core/base/dense_solves.h"

namespace likeness {

TorsoModes learn_torso_modes(const TorsoGrid& grid, const std::vector<std::vector<float>>& displacements,
                             const Eigen::MatrixXd& metric, const Vec2d& pivot) {
  TorsoModes learnt;
  const Eigen::Index size = 2 * grid.nodes(), count = Eigen::Index(displacements.size());
  const auto root = cholesky_factor(metric);
  if (count < kMinimumTorsoFrames || size == 0 || !root) return learnt;
  Eigen::MatrixXd x(count, size);
  for (Eigen::Index i = 0; i < count; ++i)
    x.row(i) = Eigen::Map<const Eigen::VectorXf>(displacements[std::size_t(i)].data(), size).cast<double>();
  const Eigen::VectorXd mean = x.colwise().mean();
  x.rowwise() -= mean.transpose();
  const Eigen::MatrixXd& lower = *root;
  Eigen::MatrixXd scaled = x * lower;

  // -- The rigid motions in the plane, seen in the same metric.
  Eigen::MatrixXd rigid = Eigen::MatrixXd::Zero(size, 3);
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column) {
      const Eigen::Index i = 2 * (row * grid.columns + column);
      rigid(i, 0) = rigid(i + 1, 1) = 1;
      rigid(i, 2) = -(grid.origin.y() + grid.cell * float(row) - pivot.y());
      rigid(i + 1, 2) = grid.origin.x() + grid.cell * float(column) - pivot.x();
    }
  const Eigen::MatrixXd seen = lower.transpose() * rigid;
  const Eigen::MatrixXd basis = orthonormal_columns(seen);
  scaled -= scaled * basis * basis.transpose();

  const SymmetricEigen spread = eigen_of_symmetric(scaled.transpose() * scaled / double(count));
  if (!spread.converged) return learnt;
  learnt.mean.resize(std::size_t(size));
  Eigen::VectorXf::Map(learnt.mean.data(), size) = mean.cast<float>();
  for (int k = 0; k < kTorsoModes; ++k) {
    const Eigen::Index at = size - 1 - k;
    Eigen::VectorXd mode =
        solve_transposed(lower, spread.vectors.col(at)) * std::sqrt(std::max(0.0, spread.values[at]));
    Eigen::Index largest = 0;
    mode.cwiseAbs().maxCoeff(&largest);
    if (mode[largest] < 0) mode = -mode;
    learnt.modes[std::size_t(k)].resize(std::size_t(size));
    Eigen::VectorXf::Map(learnt.modes[std::size_t(k)].data(), size) = mode.cast<float>();
  }
  learnt.grid = grid;
  return learnt;
}

}  // namespace likeness
