// See lone_point.h.
#include "core/track/points/lone_point.h"

#include <algorithm>

#include "core/base/dense_solves.h"
#include "core/base/quantile.h"

namespace likeness {
namespace {

constexpr double kOnHead_px = 1.5;  // median residual; the bundle adjustment drops tracks at the same
constexpr double kPointPrior = 30;  // per m, as in the bundle adjustment

double distance_px(const PointView& view, const Vec3d& point) {
  const Vec3d p = view.cam_from_head * point;
  return p.z() > 1e-3 ? (p.hnormalized() - view.ray).norm() * view.focal_px : 1e6;
}

}  // namespace

Vec3d solve_point(const std::vector<PointView>& views, const Vec3d& start) {
  Vec3d point = start;
  for (const double loss : {3.0, 1.0, 0.5}) {
    for (int iteration = 0; iteration < 5; ++iteration) {
      Mat3d hessian = kPointPrior * kPointPrior * Mat3d::Identity();
      Vec3d gradient = kPointPrior * kPointPrior * (point - start);
      for (const PointView& view : views) {
        const Vec3d p = view.cam_from_head * point;
        const double z = std::max(1e-3, p.z());
        Eigen::Matrix<double, 2, 3> by_cam;
        by_cam << 1 / z, 0, -p.x() / (z * z), 0, 1 / z, -p.y() / (z * z);
        const Eigen::Matrix<double, 2, 3> rows = view.focal_px * by_cam * view.cam_from_head.linear();
        const Vec2d r = view.focal_px * (p.head<2>() / z - view.ray);
        const double weight = 1 / (1 + r.squaredNorm() / (loss * loss));
        hessian += weight * rows.transpose() * rows;
        gradient += weight * rows.transpose() * r;
      }
      point -= solve_symmetric<3>(hessian, gradient);
    }
  }
  return point;
}

std::vector<double> foreseen_errors(const std::vector<PointView>& views, const Vec3d& start) {
  if (views.size() < kFewestPointViews) return {};
  std::vector<PointView> even, odd;
  for (std::size_t k = 0; k < views.size(); ++k) (k % 2 == 0 ? even : odd).push_back(views[k]);
  const Vec3d point = solve_point(even, start);
  std::vector<double> errors;
  for (const PointView& view : even) errors.push_back(distance_px(view, point));
  if (median(errors) > kOnHead_px) return {};
  errors.clear();
  for (const PointView& view : odd) errors.push_back(distance_px(view, point));
  return errors;
}

}  // namespace likeness
