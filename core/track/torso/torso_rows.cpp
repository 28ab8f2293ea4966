// See torso_rows.h.
#include "core/track/torso/torso_rows.h"

#include <cmath>

namespace likeness {

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
  if (holds(view.frame->head_outline, full, kTorsoHeadMargin)) return false;
  float value;
  Vec2d slope;
  if (!view.level->sample(px.x(), px.y(), &value, &slope)) return false;
  const double fx = k.fx * view.level->scale / p.z(), fy = k.fy * view.level->scale / p.z();
  const Vec3d by_cam(slope.x() * fx, slope.y() * fy,
                     -(slope.x() * fx * p.x() + slope.y() * fy * p.y()) / p.z());
  const Mat3d to_cam = view.frame->cam_from_world.linear() * view.reference.linear();
  const Vec3d along = to_cam.transpose() * by_cam;  // of the reference torso's axes
  const Vec2d by = along.head<2>();
  const Vec2d arm = moved.head<2>() - pivot - state.motion.shift;
  row->residual = value - pixel.value;
  const double size = std::abs(row->residual);
  row->weight = pixel.weight * (size <= kTorsoHuber ? 1.0 : kTorsoHuber / size);
  row->cost =
      pixel.weight * (size <= kTorsoHuber ? 0.5 * size * size : kTorsoHuber * (size - 0.5 * kTorsoHuber));
  row->by << arm.x() * by.y() - arm.y() * by.x(), by.x(), by.y(), view.approaches ? along.z() : 0;
  row->by_place = pose.linear().topLeftCorner<2, 2>().transpose() * by;
  row->at = place_in(grid, float(pixel.place.x()), float(pixel.place.y()));
  return true;
}

}  // namespace likeness
