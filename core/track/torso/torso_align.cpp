// Rows of the Jacobian are sparse: four numbers of motion, then at most eight of the nodes around the pixel,
// or one per mode.
#include "core/track/torso/torso_align.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/dense_solves.h"
#include "core/base/rigid.h"
#include "core/track/torso/torso_rows.h"

namespace likeness {
namespace {

constexpr double kStiffness = 1e8;  // grey levels^2 / m^2, between nodes of a free grid, and in the metric

struct Row {
  std::array<int, kTorsoRigid + 8> index;
  std::array<double, kTorsoRigid + 8> value;
  int count = 0;
  void add(int i, double v) { index[std::size_t(count)] = i, value[std::size_t(count)] = v, ++count; }
};

}  // namespace

double align_torso(const std::vector<TorsoPixel>& pixels, const TorsoView& view, const Vec2d& pivot,
                   const TorsoGrid& grid, const TorsoModes* modes, TorsoFreedom freedom, int iterations,
                   TorsoState* state) {
  const int extra = freedom == TorsoFreedom::rigid   ? 0
                    : freedom == TorsoFreedom::modes ? kTorsoModes
                                                     : 2 * grid.nodes();
  const int size = kTorsoRigid + extra;
  if (freedom == TorsoFreedom::nodes && state->displacement.empty())
    state->displacement.assign(std::size_t(extra), 0.f);
  if (freedom == TorsoFreedom::modes) state->displacement = posed_displacement(*modes, state->shape);
  double mean_difference = 0;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    TorsoMotion& motion = state->motion;
    const Pose pose = motion_pose(motion, pivot);
    double sum = 0, weights = 0;
    int count = 0;
    for (const TorsoPixel& t : pixels) {
      TorsoRow seen;
      if (!torso_row(t, view, pose, pivot, grid, *state, &seen)) continue;
      sum += t.weight * std::abs(seen.residual), weights += t.weight;
      ++count;
      const double r = seen.residual, weight = seen.weight;
      Row row;
      for (int k = 0; k < kTorsoRigid; ++k) row.add(k, seen.by[k]);
      if (freedom == TorsoFreedom::nodes)
        for (int k = 0; k < 8; ++k) row.add(kTorsoRigid + seen.node_index(k), seen.by_node(k));
      if (freedom == TorsoFreedom::modes)
        for (int m = 0; m < kTorsoModes; ++m)
          row.add(kTorsoRigid + m, seen.by_mode(modes->modes[std::size_t(m)]));
      for (int a = 0; a < row.count; ++a) {
        const double wa = weight * row.value[std::size_t(a)];
        gradient[row.index[std::size_t(a)]] += wa * r;
        for (int b = 0; b < row.count; ++b)
          hessian(row.index[std::size_t(a)], row.index[std::size_t(b)]) += wa * row.value[std::size_t(b)];
      }
    }
    if (count < 50) return 1e9;
    mean_difference = sum / weights;
    const double share = weights / kTorsoPixelsMeant;
    for (int i = 0; i < kTorsoRigid; ++i) hessian(i, i) += kTorsoMotionPrior;
    if (view.approaches) {
      hessian(3, 3) += kTorsoDepthPrior * share;
      gradient[3] += kTorsoDepthPrior * share * (motion.depth - view.head_depth);
    }
    if (freedom == TorsoFreedom::nodes) {
      const Eigen::VectorXd at =
          Eigen::Map<const Eigen::VectorXf>(state->displacement.data(), extra).cast<double>();
      add_smoothness(grid, kStiffness * share, &at, kTorsoRigid, &hessian, &gradient, nullptr);
    }
    if (freedom == TorsoFreedom::modes)
      for (int m = 0; m < kTorsoModes; ++m) {
        hessian(kTorsoRigid + m, kTorsoRigid + m) += kTorsoShapeNoise * kTorsoShapeNoise * share;
        gradient[kTorsoRigid + m] +=
            kTorsoShapeNoise * kTorsoShapeNoise * share * state->shape[std::size_t(m)];
      }
    const Eigen::VectorXd step = -solve_symmetric(hessian, gradient);
    if (!step.allFinite()) return 1e9;
    motion.angle += step[0];
    motion.shift += step.segment<2>(1);
    motion.depth += step[3];
    double largest = 0.2 * std::abs(step[0]) + step.segment<2>(1).norm() + 0.2 * std::abs(step[3]);
    if (freedom == TorsoFreedom::nodes) {
      for (int i = 0; i < extra; ++i) state->displacement[std::size_t(i)] += float(step[kTorsoRigid + i]);
      largest += step.tail(extra).cwiseAbs().maxCoeff();
    } else if (freedom == TorsoFreedom::modes) {
      for (int m = 0; m < kTorsoModes; ++m) state->shape[std::size_t(m)] += float(step[kTorsoRigid + m]);
      state->displacement = posed_displacement(*modes, state->shape);
      largest += 0.001 * step.tail(extra).norm();
    }
    if (largest < 2e-5) break;
  }
  return mean_difference;
}

Eigen::MatrixXd picture_metric(const std::vector<TorsoPixel>& pixels, const TorsoView& view,
                               const TorsoGrid& grid) {
  const int size = 2 * grid.nodes();
  Eigen::MatrixXd metric = Eigen::MatrixXd::Zero(size, size);
  double weights = 0;
  for (const TorsoPixel& t : pixels) {
    TorsoRow row;
    if (!torso_row(t, view, Pose::Identity(), Vec2d::Zero(), grid, {}, &row)) continue;
    weights += t.weight;
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        metric(row.node_index(a), row.node_index(b)) += t.weight * row.by_node(a) * row.by_node(b);
  }
  add_smoothness(grid, kStiffness * std::max(1.0, weights) / kTorsoPixelsMeant, nullptr, 0, &metric, nullptr,
                 nullptr);
  return metric;
}

}  // namespace likeness
