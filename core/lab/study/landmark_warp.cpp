// Moving least squares on a picture.
#include "core/lab/study/landmark_warp.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <limits>

#include "core/base/parallel.h"
#include "core/image/image.h"
#include "core/train/volumes.h"

namespace likeness {
namespace {

// Directions of the head frame in which its outline is followed. The back is left out: it moves against the
// face as the head nods, and would fold the picture.
constexpr float kOutward[][3] = {{0, 1, 0}, {0.7f, 0.7f, 0}, {-0.7f, 0.7f, 0}, {1, 0.2f, 0}, {-1, 0.2f, 0}};

// Carried by the torso: m to the person's left, below the neck's base, and forward.
constexpr double kTorsoPoints[][3] = {
    {0, 0.06, 0.05}, {-0.10, 0.10, 0.02}, {0.10, 0.10, 0.02}, {-0.20, 0.14, 0}, {0.20, 0.14, 0},
    {0, 0.16, 0.06}, {-0.12, 0.22, 0.04}, {0.12, 0.22, 0.04}, {-0.26, 0.24, 0}, {0.26, 0.24, 0}};

using Complex = std::complex<double>;
Complex complex(const Vec2d& p) { return {p.x(), p.y()}; }

Image cut_out(const TrainingView& view) {
  const Image8 alpha = to_image(view.alpha);
  Image out(view.rgb.width, view.rgb.height, 4);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const float a = alpha.empty() ? 1.f : float(*alpha.at(x, y)) / 255;
      for (int c = 0; c < 3; ++c) out.at(x, y)[c] = a * float(view.rgb.at(x, y)[c]) / 255;
      out.at(x, y)[3] = a;
    }
  return out;
}

// Bilinear; zero outside. (x, y): px, pixel centres at halves.
void sample(const Image& picture, double x, double y, float* rgba) {
  x -= 0.5, y -= 0.5;
  std::fill_n(rgba, 4, 0.f);
  if (!(x > -1 && y > -1 && x < picture.width && y < picture.height)) return;
  const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
  const double fx = x - x0, fy = y - y0;
  for (const int dy : {0, 1})
    for (const int dx : {0, 1}) {
      // The person goes on beyond the picture's border, so the border is repeated.
      const int xi = std::clamp(x0 + dx, 0, picture.width - 1),
                yi = std::clamp(y0 + dy, 0, picture.height - 1);
      const auto w = float((dx ? fx : 1 - fx) * (dy ? fy : 1 - fy));
      for (int c = 0; c < 4; ++c) rgba[c] += w * picture.at(xi, yi)[c];
    }
}

}  // namespace

ControlRig make_control_rig(const HeadModel& model, const PersonShape& person) {
  ControlRig rig{shape_head(model, person), {}, 0, {}};
  rig.neck_base = double(neck_base(model, rig.shape));
  for (const auto& outward : kOutward) {
    const Vec3f direction(outward[0], outward[1], outward[2]);
    const auto farthest =
        std::ranges::max_element(rig.shape.vertices, {}, [&](const Vec3f& p) { return direction.dot(p); });
    rig.outline.push_back(int(farthest - rig.shape.vertices.begin()));
  }
  rig.importance.assign(kLandmarkCount, 1.0);
  for (const std::size_t group : {rig.outline.size(), std::size(kTorsoPoints)})
    rig.importance.insert(rig.importance.end(), group, double(kLandmarkCount) / double(group));
  return rig;
}

std::vector<Vec2d> control_points(const HeadModel& model, const ControlRig& rig, const Camera& camera,
                                  const AvatarPose& pose) {
  std::vector<Vec2d> points;
  const auto add = [&](const Pose& world_from_part, const Vec3d& p) {
    points.push_back(project(camera.intrinsics, Vec3d(camera.cam_from_world * (world_from_part * p))));
  };
  const std::vector<Vec3f> posed = pose_head(model, rig.shape, pose.articulation);
  for (const Vec3f& p : landmark_positions(model, posed)) add(pose.world_from_head, p.cast<double>());
  for (const int v : rig.outline) add(pose.world_from_head, posed[std::size_t(v)].cast<double>());
  for (const auto& p : kTorsoPoints) add(pose.world_from_torso, {p[0], rig.neck_base - p[1], p[2]});
  return points;
}

LandmarkWarp make_landmark_warp(const TrainingSet& set) {
  LandmarkWarp warp;
  warp.rig = make_control_rig(set.model, set.person);
  const auto views = own_views(set);
  std::vector<std::vector<Vec2d>> points(views.size());
  parallel_for(views.size(), [&](std::size_t v) {
    points[v] = control_points(set.model, warp.rig, views[v].camera, views[v].pose);
  });
  std::vector<Vec2d> mean(points.front().size(), Vec2d::Zero());
  for (const auto& own : points)
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += own[i] / double(views.size());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < views.size(); ++v) {
    double away = 0;
    for (std::size_t i = 0; i < mean.size(); ++i) away += (points[v][i] - mean[i]).squaredNorm();
    if (away < least) least = away, warp.view = int(v);
  }
  warp.points = points[std::size_t(warp.view)];
  warp.picture = cut_out(views[std::size_t(warp.view)]);
  return warp;
}

Vec2d moved_back(const Vec2d& v, std::span<const Vec2d> now, std::span<const Vec2d> then,
                 std::span<const double> importance) {
  constexpr double kNear = 1e-3;  // px: distances are at least this, so that none is divided by zero
  double total = 0;
  Complex q_mean = 0, p_mean = 0;
  std::vector<double> weights(now.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    const double square = std::max((now[i] - v).squaredNorm(), kNear * kNear);
    weights[i] = importance[i] / (square * square);
    total += weights[i];
    q_mean += weights[i] * complex(now[i]), p_mean += weights[i] * complex(then[i]);
  }
  q_mean /= total, p_mean /= total;
  Complex a = 0;
  double spread = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const Complex q = complex(now[i]) - q_mean;
    a += weights[i] * std::conj(q) * (complex(then[i]) - p_mean);
    spread += weights[i] * std::norm(q);
  }
  const Complex out = (spread > 0 ? a / spread : Complex(1)) * (complex(v) - q_mean) + p_mean;
  return {out.real(), out.imag()};
}

Image render_landmark_warp(const LandmarkWarp& source, const HeadModel& model, const Camera& camera,
                           const AvatarPose& pose) {
  const std::vector<Vec2d> now = control_points(model, source.rig, camera, pose);
  Image out(source.picture.width, source.picture.height, 4);
  parallel_for(std::size_t(out.height), [&](std::size_t y) {
    for (int x = 0; x < out.width; ++x) {
      const Vec2d from = moved_back({x + 0.5, double(y) + 0.5}, now, source.points, source.rig.importance);
      sample(source.picture, from.x(), from.y(), out.at(x, int(y)));
    }
  });
  return out;
}

}  // namespace likeness
