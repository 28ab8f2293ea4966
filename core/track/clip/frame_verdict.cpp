#include "core/track/clip/frame_verdict.h"

#include <fmt/format.h>

#include <algorithm>

namespace likeness {
namespace {

constexpr double kWideSpread = 0.06;  // of the eyes' distance: an eye's opening is about a tenth
// Of the eyes' distance: a mean over the face's features of a quarter of an eye's opening is seen beside
// them.
constexpr double kBeside = 0.025;
constexpr double kStrangeLook = 0.40;  // below, something covers the face or the points lie beside it

}  // namespace

Pose pose_between(const Pose& a, const Pose& b, double t) {
  Pose pose = Pose::Identity();
  pose.linear() =
      Eigen::Quaterniond(a.linear()).slerp(t, Eigen::Quaterniond(b.linear())).normalized().toRotationMatrix();
  pose.translation() = (1 - t) * a.translation() + t * b.translation();
  return pose;
}

FrameVerdict judge_frame(const FrameEvidence& e, double usual_error_px) {
  if (!e.in_shot) return {FrameStatus::lost, "in a part of the film that is left out"};
  if (!e.camera_known) return {FrameStatus::lost, "the camera of this frame is unknown"};
  if (!e.seen) return {FrameStatus::lost, "no face found"};
  const auto misses = [&] {
    return fmt::format("the face model misses the landmarks by {:.1f} px", e.inner_error_px * e.source_px);
  };
  // What is usual of a clip excuses a frame only as far as the head still lies on the face.
  const double most_px = e.eyes_px > 0 ? kBeside * e.eyes_px : 1e9;
  if (e.inner_error_px > std::max(8.0, std::min(5 * usual_error_px, 2 * most_px)))
    return {FrameStatus::lost, misses()};
  if (e.inner_error_px > std::max(4.0, std::min(2.5 * usual_error_px, most_px)))
    return {FrameStatus::weak, misses()};
  if (e.cluster_share < 0.4)
    return {FrameStatus::weak,
            fmt::format("only {:.0f} % of the landmark runs agree", 100 * e.cluster_share)};
  if (e.spread > kWideSpread)
    return {FrameStatus::weak,
            fmt::format("the landmarks are unsure: {:.0f} % of the eyes' distance", 100 * e.spread)};
  if (e.look < kStrangeLook)
    return {FrameStatus::weak, "the face looks unlike the rest of the clip: covered, blurred or turned away"};
  if (e.votes >= 12 && e.disagreement_px > std::max(4.0, 3 * usual_error_px))
    return {FrameStatus::weak, fmt::format("the landmarks jump {:.1f} px against the picture's own motion",
                                           e.disagreement_px * e.source_px)};
  if (e.carried)
    return {FrameStatus::weak, "the face was not found here; its landmarks are followed from near frames"};
  if (!e.detected && !e.dense_solved)
    return {FrameStatus::weak, "the face was carried over from neighbouring frames"};
  return {};
}

namespace {

// The nearest frame that is not lost and that `may_know` allows, in that direction; or none.
template <class MayKnow>
const TrackedFrame* nearest(const std::vector<TrackedFrame>& frames, std::size_t from, int step,
                            const MayKnow& may_know) {
  for (auto j = std::ptrdiff_t(from) + step; j >= 0 && j < std::ptrdiff_t(frames.size()); j += step)
    if (frames[std::size_t(j)].status != FrameStatus::lost && may_know(std::size_t(j)))
      return &frames[std::size_t(j)];
  return nullptr;
}

}  // namespace

void bridge_lost(std::vector<TrackedFrame>& frames, const std::vector<bool>& held_out,
                 const std::vector<int>& shots) {
  const auto is_held_out = [&](std::size_t i) { return i < held_out.size() && held_out[i]; };
  for (std::size_t i = 0; i < frames.size(); ++i) {
    TrackedFrame& f = frames[i];
    if (f.status != FrameStatus::lost) continue;
    const auto may_know = [&](std::size_t j) { return is_held_out(i) ? j < i : !is_held_out(j); };
    const auto of_shot = [&](std::size_t j) {
      return may_know(j) && (shots.empty() || shots[j] == shots[i]);
    };
    const TrackedFrame *before = nearest(frames, i, -1, of_shot), *after = nearest(frames, i, 1, of_shot);
    if (!before && !after) before = nearest(frames, i, -1, may_know), after = nearest(frames, i, 1, may_know);
    if (!before && !after) continue;
    const TrackedFrame &a = before ? *before : *after, &b = after ? *after : *before;
    const double t = b.frame > a.frame ? static_cast<double>(f.frame - a.frame) / (b.frame - a.frame) : 0.0;
    const float s = static_cast<float>(t);
    f.pose.world_from_head = pose_between(a.pose.world_from_head, b.pose.world_from_head, t);
    f.pose.articulation.expression =
        (1 - s) * a.pose.articulation.expression + s * b.pose.articulation.expression;
    f.pose.articulation.jaw = (1 - s) * a.pose.articulation.jaw + s * b.pose.articulation.jaw;
    f.pose.articulation.left_eye = (1 - s) * a.pose.articulation.left_eye + s * b.pose.articulation.left_eye;
    f.pose.articulation.right_eye =
        (1 - s) * a.pose.articulation.right_eye + s * b.pose.articulation.right_eye;
  }
}

}  // namespace likeness
