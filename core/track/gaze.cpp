#include "core/track/gaze.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace likeness {
namespace {

constexpr double kLeastOpenness = 0.14;  // below, lashes are as dark as the iris
constexpr double kLeastWidth = 9;        // px of the eye in the picture
constexpr double kShrink = 0.85;         // the iris is partly lidded: measured turns are taken with caution
constexpr double kYawLimit = 0.55, kPitchLimit = 0.4;  // rad

bool inside_polygon(const std::array<Vec2d, 6>& polygon, const Vec2d& p) {
  bool in = false;
  for (int i = 0, j = 5; i < 6; j = i++)
    if ((polygon[i].y() > p.y()) != (polygon[j].y() > p.y()) &&
        p.x() <
            (polygon[j].x() - polygon[i].x()) * (p.y() - polygon[i].y()) / (polygon[j].y() - polygon[i].y()) +
                polygon[i].x())
      in = !in;
  return in;
}

// Darkness-weighted centre of the eye's opening, the corners left out.
std::optional<Vec2d> iris_centre(const Image8& grey, const std::array<Vec2d, 6>& outline) {
  const Vec2d inner = outline[0], outer = outline[3], axis = outer - inner;
  const double width = axis.norm();
  std::vector<std::pair<std::uint8_t, Vec2d>> pixels;
  Vec2d low = outline[0], high = outline[0];
  for (const Vec2d& p : outline) low = low.cwiseMin(p), high = high.cwiseMax(p);
  for (int y = std::max(0, static_cast<int>(low.y()));
       y <= std::min(grey.height - 1, static_cast<int>(high.y())); ++y)
    for (int x = std::max(0, static_cast<int>(low.x()));
         x <= std::min(grey.width - 1, static_cast<int>(high.x())); ++x) {
      const Vec2d p(x + 0.5, y + 0.5);
      const double along = (p - inner).dot(axis) / (width * width);
      if (along > 0.12 && along < 0.88 && inside_polygon(outline, p)) pixels.push_back({*grey.at(x, y), p});
    }
  if (pixels.size() < 12) return std::nullopt;
  std::vector<std::uint8_t> values;
  for (const auto& p : pixels) values.push_back(p.first);
  std::sort(values.begin(), values.end());
  const double dark = values[values.size() / 20], middle = values[values.size() * 45 / 100];
  if (middle - dark < 12) return std::nullopt;
  Vec2d sum = Vec2d::Zero();
  double weight = 0;
  for (const auto& [value, p] : pixels) {
    const double w = std::clamp((middle - value) / (middle - dark), 0.0, 1.0);
    sum += w * w * p;
    weight += w * w;
  }
  return Vec2d(sum / weight);
}

}  // namespace

EyeBalls eye_balls(const HeadModel& model, const HeadShape& person) {
  EyeBalls eyes;
  eyes.centre = {person.joints[kRightEye].cast<double>(), person.joints[kLeftEye].cast<double>()};
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < model.parts.size(); ++v)
    if (model.parts[v] == HeadPart::left_eyeball) {
      sum += (person.vertices[v].cast<double>() - eyes.centre[1]).norm();
      ++count;
    }
  if (count > 0 && sum / count > 0.006 && sum / count < 0.02) eyes.radius = sum / count;
  return eyes;
}

std::optional<Gaze> measure_gaze(const Image8& grey, const Intrinsics& intrinsics, const Pose& cam_from_head,
                                 const EyeBalls& eyes, const std::array<Vec2d, kLandmarkCount>& landmarks) {
  Gaze gaze;
  double yaw = 0, pitch = 0, weight = 0;
  const Pose head_from_cam = cam_from_head.inverse();
  for (int side = 0; side < 2; ++side) {
    std::array<Vec2d, 6> outline;
    for (int k = 0; k < 6; ++k) outline[k] = landmarks[36 + 6 * side + k];
    const double width = (outline[3] - outline[0]).norm();
    const double height = 0.5 * ((outline[1] - outline[5]).norm() + (outline[2] - outline[4]).norm());
    gaze.openness += 0.5 * height / std::max(1.0, width);
    if (width < kLeastWidth || height < kLeastOpenness * width) continue;
    const auto iris = iris_centre(grey, outline);
    if (!iris) continue;
    // The ray through the iris meets the eyeball's near side, or passes it: then its closest place counts.
    const Vec3d origin = head_from_cam.translation();
    const Vec3d direction = (head_from_cam.linear() * ray_direction(intrinsics, *iris)).normalized();
    const Vec3d to_centre = eyes.centre[side] - origin;
    const double along = to_centre.dot(direction), miss2 = to_centre.squaredNorm() - along * along;
    const double depth2 = eyes.radius * eyes.radius - miss2;
    const Vec3d hit = origin + (along - std::sqrt(std::max(0.0, depth2))) * direction;
    const Vec3d look = (hit - eyes.centre[side]).normalized();
    if (look.z() < 0.3) continue;
    const double w = width;  // the nearer eye is wider and seen better
    yaw += w * std::atan2(look.x(), look.z());
    pitch += w * std::asin(std::clamp(look.y(), -1.0, 1.0));
    weight += w;
  }
  if (weight == 0) return std::nullopt;
  gaze.yaw = std::clamp(kShrink * yaw / weight, -kYawLimit, kYawLimit);
  gaze.pitch = std::clamp(kShrink * pitch / weight, -kPitchLimit, kPitchLimit);
  return gaze;
}

Vec3f eye_rotation(const Gaze& gaze) {
  // +y turns z towards +x (the subject's left); -x turns z upwards.
  const Eigen::AngleAxisd turn(Eigen::AngleAxisd(gaze.yaw, Vec3d::UnitY()) *
                               Eigen::AngleAxisd(-gaze.pitch, Vec3d::UnitX()));
  return (turn.angle() * turn.axis()).cast<float>();
}

}  // namespace likeness
