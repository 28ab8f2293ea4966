// Rows of the Jacobian are sparse: three numbers of motion, then at most eight of the nodes around the pixel,
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
constexpr double kHeadMargin = 6;   // px

struct Row {
  std::array<int, kTorsoRigid + 8> index;
  std::array<double, kTorsoRigid + 8> value;
  int count = 0;
  void add(int i, double v) { index[std::size_t(count)] = i, value[std::size_t(count)] = v, ++count; }
};

}  // namespace

void add_smoothness(const TorsoGrid& grid, double stiffness, const Eigen::VectorXd* at, int first,
                    Eigen::MatrixXd* hessian, Eigen::VectorXd* gradient, double* cost) {
  constexpr double kRest = 1e-4;
  const auto tie = [&](int a, int b) {
    for (int c = 0; c < 2; ++c) {
      const int i = first + 2 * a + c, j = first + 2 * b + c;
      if (hessian) {
        (*hessian)(i, i) += stiffness, (*hessian)(j, j) += stiffness;
        (*hessian)(i, j) -= stiffness, (*hessian)(j, i) -= stiffness;
      }
      if (!at) continue;
      const double apart = (*at)[i - first] - (*at)[j - first];
      if (gradient) (*gradient)[i] += stiffness * apart, (*gradient)[j] -= stiffness * apart;
      if (cost) *cost += 0.5 * stiffness * apart * apart;
    }
  };
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column) {
      const int node = row * grid.columns + column;
      if (column + 1 < grid.columns) tie(node, node + 1);
      if (row + 1 < grid.rows) tie(node, node + grid.columns);
      for (int c = 0; c < 2; ++c) {  // and weakly to rest
        const int i = first + 2 * node + c;
        if (hessian) (*hessian)(i, i) += kRest * stiffness;
        if (!at) continue;
        const double off = (*at)[i - first];
        if (gradient) (*gradient)[i] += kRest * stiffness * off;
        if (cost) *cost += 0.5 * kRest * stiffness * off * off;
      }
    }
}

bool torso_row(const TorsoPixel& pixel, const TorsoView& view, const Pose& pose, const Vec2d& pivot,
               const TorsoGrid& grid, const TorsoState& state, TorsoRow* row) {
  if (pixel.weight <= 0) return false;
  const Vec3d moved = pose * displaced(grid, state.displacement, pixel.place),
              p = view.frame->cam_from_world * (view.reference * moved);
  if (p.z() < 0.05) return false;
  const Intrinsics& k = view.frame->intrinsics;
  const Vec2d full = project<double>(k, p), px = full * view.level->scale;
  if (holds(view.frame->head_outline, full, kHeadMargin)) return false;
  float value;
  Vec2d slope;
  if (!view.level->sample(px.x(), px.y(), &value, &slope)) return false;
  const double fx = k.fx * view.level->scale / p.z(), fy = k.fy * view.level->scale / p.z();
  const Vec3d by_cam(slope.x() * fx, slope.y() * fy,
                     -(slope.x() * fx * p.x() + slope.y() * fy * p.y()) / p.z());
  const Mat3d to_cam = view.frame->cam_from_world.linear() * view.reference.linear();
  const Vec2d by = (to_cam.transpose() * by_cam).head<2>();  // of the reference torso's x and y
  const Vec2d arm = moved.head<2>() - pivot - state.motion.shift;
  row->residual = value - pixel.value;
  const double size = std::abs(row->residual);
  row->weight = pixel.weight * (size <= kTorsoHuber ? 1.0 : kTorsoHuber / size);
  row->cost =
      pixel.weight * (size <= kTorsoHuber ? 0.5 * size * size : kTorsoHuber * (size - 0.5 * kTorsoHuber));
  row->by << arm.x() * by.y() - arm.y() * by.x(), by.x(), by.y();
  row->by_place = pose.linear().topLeftCorner<2, 2>().transpose() * by;
  row->at = place_in(grid, float(pixel.place.x()), float(pixel.place.y()));
  return true;
}

Pose motion_pose(const TorsoMotion& m, const Vec2d& pivot) {
  Pose pose = Pose::Identity();
  pose.linear() = rotation_about(Vec3d::UnitZ(), m.angle);
  const Vec3d about(pivot.x(), pivot.y(), 0);
  pose.translation() = about + Vec3d(m.shift.x(), m.shift.y(), 0) - pose.linear() * about;
  return pose;
}

bool seen_at(const TorsoView& view, const Pose& motion, const Vec3d& posed, Vec2d* px) {
  const Vec3d p = view.frame->cam_from_world * (view.reference * (motion * posed));
  if (p.z() < 0.05) return false;
  const Vec2d full = project<double>(view.frame->intrinsics, p);
  *px = full * view.level->scale;
  return !holds(view.frame->head_outline, full, kHeadMargin);
}

Vec3d displaced(const TorsoGrid& grid, const std::vector<float>& displacement, const Vec3d& place) {
  if (displacement.empty()) return place;
  const GridPlace at = place_in(grid, float(place.x()), float(place.y()));
  Vec3d moved = place;
  for (std::size_t k = 0; k < 4; ++k)
    for (int c = 0; c < 2; ++c)
      moved[c] += double(at.weight[k]) * displacement[2 * std::size_t(at.node[k]) + std::size_t(c)];
  return moved;
}

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
    double largest = 0.2 * std::abs(step[0]) + step.segment<2>(1).norm();
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
