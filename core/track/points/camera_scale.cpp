#include "core/track/points/camera_scale.h"

#include <algorithm>
#include <cmath>

#include "core/base/quantile.h"

namespace likeness {

Pose metric_camera(const Pose& cam_from_world, double metres_per_unit) {
  Pose pose = cam_from_world;
  pose.translation() *= metres_per_unit;
  return pose;
}

std::optional<double> steady_metres_per_unit(const std::vector<HeadSighting>& sightings) {
  // Head in the world: R^T (c - s t) = a + s b with a = R^T c in metres and b = the camera's centre in units.
  std::vector<Vec3d> a, b;
  for (const HeadSighting& h : sightings) {
    const Mat3d back = h.cam_from_world.linear().transpose();
    a.push_back(back * h.cam_from_head.translation());
    b.push_back(-back * h.cam_from_world.translation());
  }
  std::vector<std::pair<Vec3d, Vec3d>> steps;
  for (std::size_t gap : {3, 7, 15, 31, 63})
    for (std::size_t i = 0; i + gap < a.size(); ++i) steps.push_back({a[i + gap] - a[i], b[i + gap] - b[i]});
  if (steps.empty()) return std::nullopt;
  // Steps in which the camera moves most are the most informative; the others would only add the head's own
  // motion. A capture may rest for most of its length, so a step must also be more than jitter compared with
  // the long ones.
  std::vector<double> lengths;
  for (const auto& s : steps) lengths.push_back(s.second.norm());
  std::sort(lengths.begin(), lengths.end());
  const double least = std::max(lengths[lengths.size() / 2], 0.05 * lengths[lengths.size() * 95 / 100]);
  std::erase_if(steps, [&](const auto& s) { return s.second.norm() < least || s.second.norm() <= 1e-12; });
  if (steps.empty()) return std::nullopt;

  double scale = 0;
  std::vector<double> weights(steps.size(), 1.0), residuals(steps.size());
  for (int iteration = 0; iteration < 40; ++iteration) {
    double along = 0, moved = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      along -= weights[i] * steps[i].first.dot(steps[i].second);
      moved += weights[i] * steps[i].second.squaredNorm();
    }
    if (moved <= 0) return std::nullopt;
    scale = along / moved;
    for (std::size_t i = 0; i < steps.size(); ++i)
      residuals[i] = (steps[i].first + scale * steps[i].second).norm();
    const double width = std::max(1e-6, median(residuals));
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const double r = residuals[i] / width;
      weights[i] = 1 / (1 + r * r);
    }
  }
  // The camera must have moved by more than the head's wander, else the scale is noise.
  lengths.clear();
  for (const auto& s : steps) lengths.push_back(s.second.norm());
  if (scale <= 0 || scale * median(lengths) < median(residuals)) return std::nullopt;
  return scale;
}

}  // namespace likeness
