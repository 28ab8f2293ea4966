// See track_annotations.h.
#include "core/lab/study/track_annotations.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/head/action_amounts.h"
#include "core/head/pose_head.h"

namespace likeness {
namespace {

struct Followed {
  const char *name, *action;
  int first_landmark, last_landmark;  // of the 68 that frame what moves
};
constexpr Followed kFollowed[] = {
    {"mouth", "jawOpen", 48, 67}, {"right eye", "eyeBlink_R", 36, 41}, {"left eye", "eyeBlink_L", 42, 47}};
constexpr float kSmallestRange = 0.05f;  // of an action, 2nd to 98th percentile; less is the track's noise
constexpr std::size_t kMinFrames = 6;    // frames of an attribute
constexpr double kMargin = 0.3;          // of the landmarks' box, on every side: a user paints generously

float percentile(const std::vector<float>& sorted, double share) {
  return sorted[std::size_t(std::lround(share * double(sorted.size() - 1)))];
}

// The landmarks' box in the source's pixels; nullopt if the face is behind the camera.
std::optional<Strokes> painted_box(const TrainingSet& set, const HeadShape& shape, const TrainingView& view,
                                   const SquareCrop& crop, const Followed& followed) {
  const auto landmarks = landmark_positions(set.model, pose_head(set.model, shape, view.pose.articulation));
  const Pose cam_from_head = view.camera.cam_from_world * view.pose.world_from_head;
  Vec2d low = Vec2d::Constant(1e9), high = -low;
  for (int i = followed.first_landmark; i <= followed.last_landmark; ++i) {
    const Vec3d point = cam_from_head * landmarks[std::size_t(i)].cast<double>();
    if (point.z() <= 0) return std::nullopt;
    const Vec2d pixel = project(view.camera.intrinsics, point);
    low = low.cwiseMin(pixel), high = high.cwiseMax(pixel);
  }
  const double margin = kMargin * (high - low).maxCoeff(), scale = double(crop.side) / set.size;
  const Vec2d corner(crop.x, crop.y);
  return strokes_of_box(corner + scale * (low.array() - margin).matrix(),
                        corner + scale * (high.array() + margin).matrix());
}

}  // namespace

PaintedAttributes annotate_from_track(const TrainingSet& set, const Capture& capture, double share) {
  PaintedAttributes painted;
  const std::span<const TrainingView> views = own_views(set);
  if (views.empty()) return painted;
  const HeadShape shape = shape_head(set.model, set.person);
  const ActionBasis basis = action_basis(set.model);
  std::vector<Eigen::VectorXf> amounts;
  for (const TrainingView& view : views) amounts.push_back(face_amounts(basis, view.pose.articulation));
  const std::size_t count =
      std::min(views.size(), std::max(kMinFrames, std::size_t(std::lround(share * double(views.size())))));
  for (const Followed& followed : kFollowed) {
    const int action = action_index(basis, followed.action);
    if (action < 0) continue;
    const auto amount = [&](std::size_t v) { return amounts[v][action]; };
    std::vector<std::size_t> order(views.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::ranges::stable_sort(order, {}, amount);
    std::vector<float> sorted;
    for (const std::size_t v : order) sorted.push_back(amount(v));
    const float low = percentile(sorted, 0.02), middle = percentile(sorted, 0.5),
                high = percentile(sorted, 0.98);
    if (high - low < kSmallestRange) continue;
    const float unit = std::max(high - middle, middle - low);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t v = order[k * (views.size() - 1) / std::max<std::size_t>(1, count - 1)];
      AttributeAnnotation annotation{.frame = views[v].camera.frame,
                                     .value = std::clamp((amount(v) - middle) / unit, -1.f, 1.f)};
      if (auto box = painted_box(set, shape, views[v], capture.crop, followed)) annotation.region = *box;
      annotate(painted, followed.name, std::move(annotation));
    }
  }
  return painted;
}

}  // namespace likeness
