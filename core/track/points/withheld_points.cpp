// Points from even observations, errors of odd ones: see withheld_points.h.
#include "core/track/points/withheld_points.h"

#include <algorithm>

#include "core/base/dense_solves.h"
#include "core/base/quantile.h"
#include "core/track/points/camera_scale.h"

namespace likeness {
namespace {

constexpr double kOnHead_px = 1.5;  // median residual; the bundle adjustment drops tracks at the same
constexpr double kPointPrior = 30;  // per m, as in the bundle adjustment
constexpr std::size_t kFewestViews = 4;

struct View {
  Pose cam_from_head;
  Vec2d ray;
  double focal_px;
};

double residual_px(const View& view, const Vec3d& point) {
  const Vec3d p = view.cam_from_head * point;
  return p.z() > 1e-3 ? (p.hnormalized() - view.ray).norm() * view.focal_px : 1e6;
}

// Gauss-Newton with Cauchy weights, pulled a little to the start: a few frames do not determine depth.
Vec3d solve_point(const std::vector<View>& views, const Vec3d& start) {
  Vec3d point = start;
  for (const double loss : {3.0, 1.0, 0.5}) {
    for (int iteration = 0; iteration < 5; ++iteration) {
      Mat3d hessian = kPointPrior * kPointPrior * Mat3d::Identity();
      Vec3d gradient = kPointPrior * kPointPrior * (point - start);
      for (const View& view : views) {
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

}  // namespace

bool is_withheld(std::size_t index, double share) {
  std::uint32_t bits = std::uint32_t(index) * 2654435761u;
  bits ^= bits >> 15, bits *= 2246822519u, bits ^= bits >> 13;
  return bits < share * 4294967296.0;
}

WithheldScore score_withheld(const WithheldPoints& points, const Track& track, const CameraSet& cameras) {
  WithheldScore score;
  std::vector<double> residuals;
  for (const WithheldTrack& withheld : points.tracks) {
    std::vector<View> even, odd;
    for (std::size_t k = 0; k < withheld.seen.size(); ++k) {
      const WithheldObservation& o = withheld.seen[k];
      const TrackedFrame* frame = find_tracked(track, o.frame);
      const Camera* camera = find_camera(cameras, o.frame);
      if (!frame || !camera || frame->status == FrameStatus::lost) continue;
      const Pose cam_from_world = metric_camera(camera->cam_from_world, track.metres_per_unit);
      (k % 2 == 0 ? even : odd).push_back({cam_from_world * frame->pose.world_from_head, o.ray, o.focal_px});
    }
    if (even.size() < kFewestViews || odd.empty()) continue;
    ++score.tracks;
    const Vec3d point = solve_point(even, withheld.start);
    std::vector<double> own;
    for (const View& view : even) own.push_back(residual_px(view, point));
    if (quantile(std::move(own), 0.5) > kOnHead_px) continue;
    ++score.on_head;
    for (const View& view : odd) residuals.push_back(residual_px(view, point));
  }
  score.observations = int(residuals.size());
  score.median_px = quantile(residuals, 0.5);
  score.p90_px = quantile(std::move(residuals), 0.9);
  return score;
}

}  // namespace likeness
