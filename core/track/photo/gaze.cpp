// After Daugman's integro-differential operator (PAMI 1993), with the circle drawn on the eyeball: along it,
// brightness should step up outwards. Parts under the lids are left out; the disc inside the opening should
// be dark.
#include "core/track/photo/gaze.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace likeness {
namespace {

constexpr double kMinOpenness = 0.12;                  // below, lashes are as dark as the iris
constexpr double kMinWidth = 8;                        // px of the eye in the picture
constexpr double kMinContrast = 10;                    // levels between iris and white
constexpr double kYawLimit = 0.6, kPitchLimit = 0.45;  // rad
constexpr double kIrisShare = 0.49;                    // iris radius over eyeball radius
constexpr int kAngles = 40;                            // places along the circle
constexpr double kDarkWeight = 0.6;                    // of the dark disc against the edge
constexpr double kStraightPull = 0.12;  // score per radian^2 from straight ahead: decisive when lids are low
constexpr double kMinConfidence = 0.12;
constexpr double kDisagreement = 0.30;  // rad between the eyes: beyond it only the more confident one counts

using Outline = std::array<Vec2d, 6>;

bool inside_polygon(const Outline& polygon, const Vec2d& p) {
  bool in = false;
  for (int i = 0, j = 5; i < 6; j = i++)
    if ((polygon[i].y() > p.y()) != (polygon[j].y() > p.y()) &&
        p.x() <
            (polygon[j].x() - polygon[i].x()) * (p.y() - polygon[i].y()) / (polygon[j].y() - polygon[i].y()) +
                polygon[i].x())
      in = !in;
  return in;
}

// The picture of an eye as used by the search, in levels relative to its own contrast.
class EyeView {
 public:
  EyeView(const Image8& grey, const Intrinsics& intrinsics, const Pose& cam_from_head, const Vec3d& centre,
          double radius, const Outline& outline)
      : grey_(grey),
        intrinsics_(intrinsics),
        cam_from_head_(cam_from_head),
        centre_(centre),
        radius_(radius),
        outline_(outline) {
    std::vector<std::uint8_t> levels;
    Vec2d low = outline[0], high = outline[0];
    for (const Vec2d& p : outline) low = low.cwiseMin(p), high = high.cwiseMax(p);
    for (int y = std::max(0, static_cast<int>(low.y())); y <= high.y() && y < grey.height; ++y)
      for (int x = std::max(0, static_cast<int>(low.x())); x <= high.x() && x < grey.width; ++x)
        if (inside_polygon(outline, Vec2d(x + 0.5, y + 0.5))) levels.push_back(*grey.at(x, y));
    if (levels.size() < 12) return;
    std::sort(levels.begin(), levels.end());
    dark_ = levels[levels.size() / 10];
    bright_ = levels[levels.size() * 8 / 10];
  }

  bool usable() const { return bright_ - dark_ >= kMinContrast; }

  struct Score {
    double value = -1e9;
    double edge = 0;   // mean step over the seen part of the circle, 1 = full contrast
    double share = 0;  // of the circle that is seen
  };
  Score score(double yaw, double pitch) const {
    const Mat3d turn = (Eigen::AngleAxisd(yaw, Vec3d::UnitY()) * Eigen::AngleAxisd(-pitch, Vec3d::UnitX()))
                           .toRotationMatrix();
    double edge = 0, darkness = 0;
    int seen = 0, inside = 0;
    for (int k = 0; k < kAngles; ++k) {
      const double a = 2 * std::numbers::pi * k / kAngles;
      double out = 0, in = 0, disc = 0;
      const bool near = look(turn, a, 0.82, &in), far = look(turn, a, 1.2, &out);
      if (near && far) edge += std::clamp((out - in) / (bright_ - dark_), -1.0, 1.0), ++seen;
      if (near) darkness += std::clamp((bright_ - in) / (bright_ - dark_), 0.0, 1.0), ++inside;
      if (k % 2 == 0 && look(turn, a, 0.5, &disc))
        darkness += std::clamp((bright_ - disc) / (bright_ - dark_), 0.0, 1.0), ++inside;
    }
    Score s;
    if (inside < kAngles / 5) return s;
    s.share = static_cast<double>(seen) / kAngles;
    s.edge = seen > 0 ? edge / seen : 0;
    // A short arc proves little: the edge is weighted by its visible share.
    s.value = edge / kAngles * 1.5 +
              kDarkWeight * darkness / inside * std::min(1.0, inside / (0.6 * kAngles)) -
              kStraightPull * (yaw * yaw + pitch * pitch);
    return s;
  }

 private:
  // Picture at a share of the iris' radius around the gaze; false under lids and outside the picture.
  bool look(const Mat3d& turn, double angle, double share, double* level) const {
    const double r = kIrisShare * share;
    const Vec3d on_eye(r * std::cos(angle), r * std::sin(angle), std::sqrt(std::max(0.0, 1 - r * r)));
    const Vec3d in_cam = cam_from_head_ * Vec3d(centre_ + radius_ * (turn * on_eye));
    if (in_cam.z() < 0.05) return false;
    const Vec2d px = project<double>(intrinsics_, in_cam);
    const double x = px.x() - 0.5, y = px.y() - 0.5;
    if (!inside_polygon(outline_, px) || x < 0 || y < 0 || x >= grey_.width - 1 || y >= grey_.height - 1)
      return false;
    const int ix = static_cast<int>(x), iy = static_cast<int>(y);
    const double fx = x - ix, fy = y - iy;
    const std::uint8_t *top = grey_.at(ix, iy), *bottom = grey_.at(ix, iy + 1);
    *level = (1 - fy) * ((1 - fx) * top[0] + fx * top[1]) + fy * ((1 - fx) * bottom[0] + fx * bottom[1]);
    return true;
  }

  const Image8& grey_;
  const Intrinsics& intrinsics_;
  const Pose& cam_from_head_;
  const Vec3d centre_;
  const double radius_;
  const Outline& outline_;
  double dark_ = 0, bright_ = 0;
};

// The lowest point of a parabola through three scores a step apart, as a share of the step.
double peak_offset(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend < -1e-9 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

EyeGaze search(const EyeView& view) {
  EyeGaze best;
  EyeView::Score top;
  double step = 0.1;
  for (double yaw = -kYawLimit; yaw <= kYawLimit + 1e-9; yaw += step)
    for (double pitch = -kPitchLimit; pitch <= kPitchLimit + 1e-9; pitch += step)
      if (const auto s = view.score(yaw, pitch); s.value > top.value)
        top = s, best.yaw = yaw, best.pitch = pitch;
  if (top.value < -1e8) return best;
  for (step = 0.05; step > 0.008; step *= 0.5) {
    const double yaw = best.yaw, pitch = best.pitch;
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        if (const auto s = view.score(yaw + i * step, pitch + j * step); s.value > top.value)
          top = s, best.yaw = yaw + i * step, best.pitch = pitch + j * step;
  }
  constexpr double kFine = 0.03;  // rad, wider than the picture's grain
  const double yaw = best.yaw, pitch = best.pitch;
  best.yaw += kFine * peak_offset(view.score(yaw - kFine, pitch).value, top.value,
                                  view.score(yaw + kFine, pitch).value);
  best.pitch += kFine * peak_offset(view.score(yaw, pitch - kFine).value, top.value,
                                    view.score(yaw, pitch + kFine).value);
  best.yaw = std::clamp(best.yaw, -kYawLimit, kYawLimit);
  best.pitch = std::clamp(best.pitch, -kPitchLimit, kPitchLimit);
  best.confidence = std::clamp(1.6 * top.edge * std::min(1.0, 2 * top.share), 0.0, 1.0);
  return best;
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
  for (int side = 0; side < 2; ++side) {
    Outline outline;
    for (int k = 0; k < 6; ++k) outline[k] = landmarks[36 + 6 * side + k];
    const double width = (outline[3] - outline[0]).norm();
    const double height = 0.5 * ((outline[1] - outline[5]).norm() + (outline[2] - outline[4]).norm());
    gaze.openness += 0.5 * height / std::max(1.0, width);
    if (width < kMinWidth || height < kMinOpenness * width) continue;
    const EyeView view(grey, intrinsics, cam_from_head, eyes.centre[side], eyes.radius, outline);
    if (!view.usable()) continue;
    EyeGaze& eye = gaze.eye[side];
    eye = search(view);
    eye.confidence *= std::clamp((height / width - kMinOpenness) / 0.08, 0.2, 1.0);
    if (eye.confidence < kMinConfidence) eye.confidence = 0;
  }
  const EyeGaze &right = gaze.eye[0], &left = gaze.eye[1];
  double w_right = right.confidence, w_left = left.confidence;
  if (w_right + w_left <= 0) return std::nullopt;
  if (w_right > 0 && w_left > 0 && std::hypot(right.yaw - left.yaw, right.pitch - left.pitch) > kDisagreement)
    (w_right > w_left ? w_left : w_right) = 0;
  gaze.yaw = (w_right * right.yaw + w_left * left.yaw) / (w_right + w_left);
  gaze.pitch = (w_right * right.pitch + w_left * left.pitch) / (w_right + w_left);
  return gaze;
}

Vec3f eye_rotation(const Gaze& gaze) {
  // +y turns z towards +x (the subject's left); -x turns z upwards.
  const Eigen::AngleAxisd turn(Eigen::AngleAxisd(gaze.yaw, Vec3d::UnitY()) *
                               Eigen::AngleAxisd(-gaze.pitch, Vec3d::UnitX()));
  return (turn.angle() * turn.axis()).cast<float>();
}

}  // namespace likeness
