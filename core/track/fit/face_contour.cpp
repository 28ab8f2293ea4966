#include "core/track/fit/face_contour.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/base/rigid.h"
#include "core/head/pose_head.h"
#include "core/image/bilinear.h"
#include "core/scene/head_regions.h"
#include "core/scene/mesh_scene.h"
#include "core/track/fit/shape_field.h"

namespace likeness {
namespace {

constexpr float kBehind = 0.012f;    // m of air behind an outline
constexpr double kOutside = 0.0015;  // m beyond the surface, where the depth behind it is probed
constexpr float kMouth = 0.012f;     // m from the line between the lips: they open and close
constexpr double kCell = 2;          // px between contour points
constexpr double kStep = 0.5;        // px between samples of a profile
constexpr double kBlur = 1.2;        // px, of the profile's derivative
constexpr double kMinSlope = 3.5;    // levels a px of an edge
constexpr double kRival = 0.6;       // of the best edge's score: a second one this good makes both uncertain

// Derivative of the profile blurred by a Gaussian, per px; `margin` samples at both ends are left out.
std::vector<double> slopes(const std::vector<float>& profile, int margin) {
  std::vector<double> kernel;
  double sum = 0;
  for (int k = -margin; k <= margin; ++k) {
    const double t = k * kStep / kBlur;
    kernel.push_back(t * std::exp(-0.5 * t * t));
    sum += kernel.back() * k * kStep;
  }
  std::vector<double> out;
  for (std::size_t i = margin; i + margin < profile.size(); ++i) {
    double value = 0;
    for (int k = -margin; k <= margin; ++k) value += kernel[k + margin] * profile[i + k];
    out.push_back(value / sum);
  }
  return out;
}

}  // namespace

std::vector<std::uint8_t> contour_triangles(const HeadModel& model, const std::vector<Vec3f>& rest) {
  const HeadRegions regions = head_regions(model);
  const auto landmarks = landmark_positions(model, rest);
  float brow = 0;
  for (int i = 17; i <= 26; ++i) brow += landmarks[i].y() / 10;
  const float ears = 0.5f * (landmarks[0].z() + landmarks[16].z());
  std::vector<std::uint8_t> flags(model.triangles.size(), 0);
  for (std::size_t t = 0; t < flags.size(); ++t) {
    const Triangle& triangle = model.triangles[t];
    const Vec3f centre = (rest[triangle[0]] + rest[triangle[1]] + rest[triangle[2]]) / 3;
    flags[t] = regions.head[t] && regions.skin[t] && centre.y() < brow && centre.z() > ears + 0.01f &&
               lip_distance(landmarks, centre) > kMouth;
    for (int k = 0; k < 3; ++k) {
      const HeadPart part = model.parts[triangle[k]];
      flags[t] =
          flags[t] && (part == HeadPart::face || part == HeadPart::scalp_neck || part == HeadPart::unknown);
    }
  }
  return flags;
}

std::vector<ContourPoint> face_contour(const HeadModel& model, const std::vector<std::uint8_t>& candidates,
                                       const std::vector<Vec3f>& posed, const Intrinsics& intrinsics,
                                       const Pose& cam_from_head) {
  const std::vector<Vec3f> normals = vertex_normals(posed, model.triangles);
  const Vec3d eye = inverse(cam_from_head).translation();
  const MeshScene scene(posed, model.triangles);
  std::set<std::pair<int, int>> taken;
  std::vector<ContourPoint> contour;
  for (std::size_t t = 0; t < candidates.size(); ++t) {
    if (!candidates[t]) continue;
    const Triangle& triangle = model.triangles[t];
    std::array<double, 3> facing{};
    for (int k = 0; k < 3; ++k)
      facing[k] = normals[triangle[k]].cast<double>().dot(posed[triangle[k]].cast<double>() - eye);
    Vec3d weight = Vec3d::Zero();
    int crossings = 0;
    for (int k = 0; k < 3; ++k) {
      const int a = k, b = (k + 1) % 3;
      if ((facing[a] < 0) == (facing[b] < 0)) continue;
      const double along = facing[a] / (facing[a] - facing[b]);
      weight[a] += 0.5 * (1 - along), weight[b] += 0.5 * along;
      ++crossings;
    }
    if (crossings != 2) continue;
    Vec3d point = Vec3d::Zero(), normal = Vec3d::Zero();
    for (int k = 0; k < 3; ++k) {
      point += weight[k] * posed[triangle[k]].cast<double>();
      normal += weight[k] * normals[triangle[k]].cast<double>();
    }
    const Vec3d view = (point - eye).normalized();
    normal = (normal - normal.dot(view) * view).normalized();
    const Vec3d in_cam = cam_from_head * point, beside = cam_from_head * Vec3d(point + 0.001 * normal);
    if (in_cam.z() < 0.05) continue;
    ContourPoint c{static_cast<int>(t), weight, normal, project<double>(intrinsics, in_cam), {}, 0};
    const Vec2d step = project<double>(intrinsics, beside) - c.pixel;
    c.px_per_m = step.norm() / 0.001;
    c.outward = step.normalized();
    const Vec3d past = point + kOutside * normal;
    const float distance = static_cast<float>((past - eye).norm());
    if (scene.occluded(eye.cast<float>(), (past - eye).normalized().cast<float>(), 0.01f, distance + kBehind))
      continue;
    if (taken.insert({static_cast<int>(c.pixel.x() / kCell), static_cast<int>(c.pixel.y() / kCell)}).second)
      contour.push_back(c);
  }
  return contour;
}

std::optional<double> find_edge(const Image8& grey, const Vec2d& pixel, const Vec2d& outward, double reach_px,
                                double usual_px) {
  const int margin = static_cast<int>(std::ceil(3 * kBlur / kStep));
  const int half = static_cast<int>(std::ceil(reach_px / kStep));
  std::vector<float> profile;
  for (int i = -half - margin; i <= half + margin; ++i) {
    const Vec2d p = pixel + i * kStep * outward;
    if (p.x() < 1 || p.y() < 1 || p.x() > grey.width - 1 || p.y() > grey.height - 1) return std::nullopt;
    profile.push_back(static_cast<float>(bilinear(grey, p.x(), p.y())));
  }
  const std::vector<double> slope = slopes(profile, margin);
  double best = 0, second = 0, place = 0;
  for (int i = 1; i + 1 < static_cast<int>(slope.size()); ++i) {
    const double a = std::abs(slope[i - 1]), b = std::abs(slope[i]), c = std::abs(slope[i + 1]);
    if (b < kMinSlope || b < a || b <= c) continue;
    const double bend = a - 2 * b + c;
    const double at = (i - half + (bend < 0 ? 0.5 * (a - c) / bend : 0)) * kStep;
    const double score = b * std::exp(-0.5 * at * at / (usual_px * usual_px));
    if (score > best) {
      second = best;
      best = score;
      place = at;
    } else {
      second = std::max(second, score);
    }
  }
  if (best <= 0 || second > kRival * best) return std::nullopt;
  return place;
}

}  // namespace likeness
