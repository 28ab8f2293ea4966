// Landmarks of the head at rest.
#include "core/train/head_marks.h"

#include <algorithm>
#include <cmath>

namespace likeness {
namespace {

constexpr int kChin = 8, kRightEar = 0, kLeftEar = 16, kRightBrow = 19, kLeftBrow = 24, kNoseBase = 33;
constexpr float kNeckLength = 0.045f;  // m from the chin down to the base of the neck
constexpr float kNeckRing = 0.02f;     // m above and below the base

}  // namespace

HeadMarks head_marks(const HeadModel& model, const HeadShape& shape) {
  const auto posed = pose_head(model, shape, neutral_articulation(model));
  const auto landmarks = landmark_positions(model, posed);
  HeadMarks marks;
  marks.chin = landmarks[kChin].y();
  marks.nose = landmarks[kNoseBase].y();
  marks.brow = 0.5f * (landmarks[kRightBrow].y() + landmarks[kLeftBrow].y());
  marks.ear_z = 0.5f * (landmarks[kRightEar].z() + landmarks[kLeftEar].z());
  float lowest = 1e9f;
  for (std::size_t v = 0; v < posed.size(); ++v)
    if (is_skin(model, v)) lowest = std::min(lowest, posed[v].y());
  marks.base = std::max(marks.chin - kNeckLength, lowest + 0.005f);
  return marks;
}

float neck_axis(const HeadModel& model, const HeadShape& shape) {
  const float base = head_marks(model, shape).base;
  const std::vector<Vec3f> neutral = pose_head(model, shape, neutral_articulation(model));
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < neutral.size(); ++v)
    if (is_skin(model, v) && std::abs(neutral[v].y() - base) < kNeckRing) sum += neutral[v].z(), ++count;
  return count > 0 ? float(sum / count) : shape.joints[kNeck].z();
}

Vec3f head_middle(const HeadModel& model, const std::vector<Vec3f>& posed) {
  Vec3f low = Vec3f::Constant(1e9f), high = -low;
  for (const Vec3f& landmark : landmark_positions(model, posed))
    low = low.cwiseMin(landmark), high = high.cwiseMax(landmark);
  return 0.5f * (low + high) - Vec3f(0, 0, 0.5f * (high.x() - low.x()));
}

bool is_skin(const HeadModel& model, std::size_t vertex) {
  if (model.parts.empty()) return true;
  const HeadPart part = model.parts[vertex];
  return part == HeadPart::face || part == HeadPart::scalp_neck || part == HeadPart::unknown;
}

float hairiness(const HeadMarks& marks, const Vec3f& p) {
  const float above = std::clamp((p.y() - marks.brow - 0.015f) / 0.03f, 0.f, 1.f);
  const float behind = std::clamp((marks.ear_z + 0.01f - p.z()) / 0.02f, 0.f, 1.f);
  const float height = std::clamp((p.y() - marks.chin) / (marks.nose - marks.chin), 0.f, 1.f);
  return std::max(above, behind) * height;
}

}  // namespace likeness
