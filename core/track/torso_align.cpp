// Rows of the Jacobian are sparse: four numbers of motion and brightness, then at most eight of the nodes
// around the pixel, or one a mode.
#include "core/track/torso_align.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

namespace likeness {
namespace {

constexpr double kHuber = 20;          // grey levels
constexpr double kShapeNoise = 4.5;    // grey levels: how strongly the shape is drawn to the usual
constexpr double kPixelsMeant = 4000;  // priors are stated for this many pixels
constexpr double kStiffness = 1.1e9;   // grey levels^2 / m^2, between neighbouring nodes
constexpr double kMotionPrior = 1;     // tiny: keeps the system regular
constexpr double kHeadMargin = 6;      // px
constexpr int kRigid = 4;

// Value and slope of the picture where a canonical point is seen.
struct Look {
  float value = 0;
  Vec2d from_pivot;    // of the moved point, m
  Vec2d by_reference;  // d value / d (x, y) of the reference torso, grey levels per m
};

bool look_at(const TorsoView& view, const Pose& motion, const Vec2d& pivot, const Vec3d& posed, Look* look) {
  const Vec3d moved = motion * posed, p = view.frame->cam_from_world * (view.reference * moved);
  if (p.z() < 0.05) return false;
  const Intrinsics& k = view.frame->intrinsics;
  const Vec2d full = project<double>(k, p), px = full * view.level->scale;
  if (holds(view.frame->head_outline, full, kHeadMargin)) return false;
  Vec2d slope;
  if (!view.level->sample(px.x(), px.y(), &look->value, &slope)) return false;
  const double fx = k.fx * view.level->scale / p.z(), fy = k.fy * view.level->scale / p.z();
  const Vec3d by_cam(slope.x() * fx, slope.y() * fy,
                     -(slope.x() * fx * p.x() + slope.y() * fy * p.y()) / p.z());
  const Mat3d to_cam = view.frame->cam_from_world.linear() * view.reference.linear();
  look->from_pivot = moved.head<2>() - pivot;
  look->by_reference = (to_cam.transpose() * by_cam).head<2>();
  return true;
}

struct Row {
  std::array<int, kRigid + 8> index;
  std::array<double, kRigid + 8> value;
  int count = 0;
  void add(int i, double v) { index[std::size_t(count)] = i, value[std::size_t(count)] = v, ++count; }
};

void add_smoothness(const TorsoGrid& grid, double stiffness, const Eigen::VectorXd* at, int first,
                    Eigen::MatrixXd& hessian, Eigen::VectorXd* gradient) {
  const auto tie = [&](int a, int b) {
    for (int c = 0; c < 2; ++c) {
      const int i = first + 2 * a + c, j = first + 2 * b + c;
      hessian(i, i) += stiffness, hessian(j, j) += stiffness;
      hessian(i, j) -= stiffness, hessian(j, i) -= stiffness;
      if (!gradient) continue;
      const double pull = stiffness * ((*at)[i - first] - (*at)[j - first]);
      (*gradient)[i] += pull, (*gradient)[j] -= pull;
    }
  };
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column) {
      const int node = row * grid.columns + column;
      if (column + 1 < grid.columns) tie(node, node + 1);
      if (row + 1 < grid.rows) tie(node, node + grid.columns);
      for (int c = 0; c < 2; ++c) {  // and weakly to rest
        const int i = first + 2 * node + c;
        hessian(i, i) += 1e-4 * stiffness;
        if (gradient) (*gradient)[i] += 1e-4 * stiffness * (*at)[i - first];
      }
    }
}

}  // namespace

Pose motion_pose(const TorsoMotion& m, const Vec2d& pivot) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(m.angle, Vec3d::UnitZ()).toRotationMatrix();
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
  const int size = kRigid + extra;
  if (freedom == TorsoFreedom::nodes && state->displacement.empty())
    state->displacement.assign(std::size_t(extra), 0.f);
  if (freedom == TorsoFreedom::modes) state->displacement = posed_displacement(*modes, state->shape);
  double mean_difference = 0;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    TorsoMotion& motion = state->motion;
    const Pose pose = motion_pose(motion, pivot);
    const Eigen::Matrix2d back = pose.linear().topLeftCorner<2, 2>().transpose();
    double sum = 0, weights = 0;
    int count = 0;
    for (const TorsoPixel& t : pixels) {
      if (t.weight <= 0) continue;
      Look look;
      if (!look_at(view, pose, pivot, displaced(grid, state->displacement, t.place), &look)) continue;
      const double r = look.value + motion.brightness - t.value;
      sum += t.weight * std::abs(r), weights += t.weight;
      ++count;
      const double weight = t.weight * (std::abs(r) <= kHuber ? 1.0 : kHuber / std::abs(r));
      const Vec2d& by = look.by_reference;
      const Vec2d arm = look.from_pivot - motion.shift;
      Row row;
      row.add(0, arm.x() * by.y() - arm.y() * by.x());
      row.add(1, by.x()), row.add(2, by.y()), row.add(3, 1);
      if (extra > 0) {
        const Vec2d by_node = back * by;
        const GridPlace at = place_in(grid, float(t.place.x()), float(t.place.y()));
        if (freedom == TorsoFreedom::nodes)
          for (std::size_t k = 0; k < 4; ++k)
            for (int c = 0; c < 2; ++c) row.add(kRigid + 2 * at.node[k] + c, at.weight[k] * by_node[c]);
        else
          for (int m = 0; m < kTorsoModes; ++m) {
            double way = 0;
            for (std::size_t k = 0; k < 4; ++k)
              for (int c = 0; c < 2; ++c)
                way += at.weight[k] * by_node[c] *
                       modes->modes[std::size_t(m)][2 * std::size_t(at.node[k]) + std::size_t(c)];
            row.add(kRigid + m, way);
          }
      }
      for (int a = 0; a < row.count; ++a) {
        const double wa = weight * row.value[std::size_t(a)];
        gradient[row.index[std::size_t(a)]] += wa * r;
        for (int b = 0; b < row.count; ++b)
          hessian(row.index[std::size_t(a)], row.index[std::size_t(b)]) += wa * row.value[std::size_t(b)];
      }
    }
    if (count < 50) return 1e9;
    mean_difference = sum / weights;
    const double share = weights / kPixelsMeant;
    for (int i = 0; i < kRigid; ++i) hessian(i, i) += kMotionPrior;
    if (freedom == TorsoFreedom::nodes) {
      const Eigen::VectorXd at =
          Eigen::Map<const Eigen::VectorXf>(state->displacement.data(), extra).cast<double>();
      add_smoothness(grid, kStiffness * share, &at, kRigid, hessian, &gradient);
    }
    if (freedom == TorsoFreedom::modes)
      for (int m = 0; m < kTorsoModes; ++m) {
        hessian(kRigid + m, kRigid + m) += kShapeNoise * kShapeNoise * share;
        gradient[kRigid + m] += kShapeNoise * kShapeNoise * share * state->shape[std::size_t(m)];
      }
    const Eigen::VectorXd step = -hessian.ldlt().solve(gradient);
    if (!step.allFinite()) return 1e9;
    motion.angle += step[0];
    motion.shift += step.segment<2>(1);
    motion.brightness += step[3];
    double largest = 0.2 * std::abs(step[0]) + step.segment<2>(1).norm();
    if (freedom == TorsoFreedom::nodes) {
      for (int i = 0; i < extra; ++i) state->displacement[std::size_t(i)] += float(step[kRigid + i]);
      largest += step.tail(extra).cwiseAbs().maxCoeff();
    } else if (freedom == TorsoFreedom::modes) {
      for (int m = 0; m < kTorsoModes; ++m) state->shape[std::size_t(m)] += float(step[kRigid + m]);
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
    Look look;
    if (t.weight <= 0 || !look_at(view, Pose::Identity(), Vec2d::Zero(), t.place, &look)) continue;
    weights += t.weight;
    const GridPlace at = place_in(grid, float(t.place.x()), float(t.place.y()));
    Eigen::Matrix<double, 8, 1> row;
    for (int k = 0; k < 4; ++k) row.segment<2>(2 * k) = double(at.weight[std::size_t(k)]) * look.by_reference;
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        metric(2 * at.node[std::size_t(a / 2)] + a % 2, 2 * at.node[std::size_t(b / 2)] + b % 2) +=
            t.weight * row[a] * row[b];
  }
  add_smoothness(grid, kStiffness * std::max(1.0, weights) / kPixelsMeant, nullptr, 0, metric, nullptr);
  return metric;
}

}  // namespace likeness
