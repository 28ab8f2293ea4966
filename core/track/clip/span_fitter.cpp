// See span_fitter.h. What a frame's tries are and which is taken: span_tries.cpp.
#include "core/track/clip/span_fitter.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/track/clip/clip_work.h"
#include "core/track/clip/frame_verdict.h"
#include "core/track/fit/rest.h"
#include "core/track/frame_spacing.h"
#include "core/track/points/camera_scale.h"

namespace likeness {
namespace {

constexpr double kNoLandmarks = 10;  // times their sigma: as if there were none
constexpr int kWeakAnchor = 12;      // frames by which a good anchor may be farther away than a weak one
constexpr double kSameTurn = 0.12;   // rad, and
constexpr double kSameShift = 0.03;  // m that the ways from both sides may differ by

bool same_pose(const Pose& a, const Pose& b) {
  return vector_from_turn(a.linear() * b.linear().transpose()).norm() < kSameTurn &&
         (a.translation() - b.translation()).norm() < kSameShift;
}

FaceState state_between(const FaceState& a, const FaceState& b, double t) {
  return {pose_between(a.cam_from_head, b.cam_from_head, t), (1 - t) * a.jaw + t * b.jaw,
          (1 - t) * a.expression + t * b.expression};
}

}  // namespace

SpanFitter::SpanFitter(const HeadModel& model, const Track& track, const RefitOptions& options,
                       FaceDetector detector, double usual_error_px)
    : options_(options),
      detector_(std::move(detector)),
      usual_px_(usual_error_px),
      metres_per_unit_(track.metres_per_unit),
      shape_(shape_head(model, track.person)),
      head_(reduce_head(model, kIdentityDirections, track.person)),
      person_(reduced_person(head_, track.person.identity.head(head_.identity_count()).cast<double>())),
      prior_(prior_from_rest(expression_prior(model), track.neutral.expression.cast<double>())),
      rigid_(rigid_head(model, shape_)),
      eyes_(eye_balls(model, shape_)),
      surface_(face_surface(model, shape_)) {}

void SpanFitter::take(ClipFrames clip, const CameraSet& cameras, const Track& track, const RefitSpan& span) {
  std::erase_if(clip.frames, [&](const ClipFrame& frame) { return !find_tracked(track, frame.frame); });
  clip_ = std::move(clip);
  spacing_ = frame_spacing(track.frames);
  frames_.clear();
  for (const ClipFrame& source : clip_.frames) {
    SpanFrame& f = frames_.emplace_back();
    f.tracked = *find_tracked(track, source.frame);
    f.camera = find_camera(cameras, source.frame);
    f.held_out = source.held_out;
    f.target = source.frame >= span.first && source.frame <= span.last;
    if (!f.camera) continue;
    f.intrinsics = working_intrinsics(f.camera->intrinsics, clip_);
    f.cam_from_world = metric_camera(f.camera->cam_from_world, metres_per_unit_);
    f.state = {f.cam_from_world * f.tracked.pose.world_from_head, f.tracked.pose.articulation.jaw.x(),
               f.tracked.pose.articulation.expression.cast<double>()};
  }
  const Vec2d corner(clip_.region.x, clip_.region.y);
  parallel_for(frames_.size(), [&](std::size_t k) {
    std::array<Vec2d, kLandmarkCount> px;
    for (int p = 0; p < kLandmarkCount; ++p) px[p] = (frames_[k].tracked.landmarks[p] - corner) * clip_.scale;
    if (has_landmarks(frames_[k].tracked)) frames_[k].look = face_look(clip_.frames[k].grey, px);
  });
}

SpanFitter::Indices SpanFitter::targets(bool held_out) const {
  Indices found;
  for (std::size_t k = 0; k < frames_.size(); ++k)
    if (frames_[k].target && frames_[k].camera && frames_[k].held_out == held_out) found.push_back(k);
  return found;
}

// The nearest frame to lean on before (step -1) or after (1); a good one may be a little farther away. What
// is a target itself counts once it is fitted: for held-out frames, training ones are.
std::optional<std::size_t> SpanFitter::anchor(std::size_t from, int step, bool training_only) const {
  std::optional<std::size_t> best;
  int least = 0;
  for (std::ptrdiff_t j = std::ptrdiff_t(from) + step; j >= 0 && j < std::ptrdiff_t(frames_.size());
       j += step) {
    const SpanFrame& f = frames_[std::size_t(j)];
    if (!f.usable() || (training_only && f.held_out) || (f.target && (training_only || f.held_out))) continue;
    const int away = int(std::abs(j - std::ptrdiff_t(from)));
    if (away > options_.reach) break;
    const int cost = away + (f.tracked.status == FrameStatus::good ? 0 : kWeakAnchor);
    if (best && cost >= least) continue;
    best = std::size_t(j), least = cost;
  }
  return best;
}

FollowedFrame SpanFitter::step(HeadFollower& follower, std::size_t k, FaceState& last) const {
  FollowedFrame followed = follower.next(frames_[k].intrinsics, clip_.frames[k].grey);
  last.cam_from_head = followed.cam_from_head;
  if (!followed.solved) return followed;
  const Prediction prediction{last, true};
  const auto found = try_at(k, prediction);
  if (!found || !appearance_) return followed;
  // The picture says which: the points alone, the face with its landmarks, or the face without them.
  SpanTry best = *found;
  best.state = last;
  measure(k, best);
  for (const double doubt : {1.0, kNoLandmarks}) {
    SpanTry other = *found;
    for (double& s : other.observation.sigma_px) s *= doubt;
    other.state = settled(k, other, followed_pull(prediction), 2);
    measure(k, other);
    if (other.picture < best.picture && same_pose(other.state.cam_from_head, followed.cam_from_head))
      best = other;
  }
  last = best.state;
  follower.correct(last.cam_from_head);
  followed.cam_from_head = last.cam_from_head;
  return followed;
}

std::vector<FollowedFrame> SpanFitter::follow(std::size_t from, const Indices& walk,
                                              std::stop_token stop) const {
  std::vector<FollowedFrame> followed(frames_.size());
  FaceState last = frames_[from].state;
  HeadFollower follower(rigid_, frames_[from].intrinsics, clip_.frames[from].grey, last.cam_from_head);
  for (const std::size_t k : walk) {
    if (stop.stop_requested()) break;
    followed[k] = step(follower, k, last);
  }
  return followed;
}

// Where both ways lead to the same place, one prediction between them; where they do not, each is tried.
std::vector<Prediction> SpanFitter::predictions(std::size_t k, std::optional<std::size_t> left,
                                                std::optional<std::size_t> right,
                                                const FollowedFrame& forward,
                                                const FollowedFrame& backward) const {
  const auto number = [&](std::size_t i) { return double(frames_[i].tracked.frame); };
  const double t = !left    ? 1
                   : !right ? 0
                            : (number(k) - number(*left)) / std::max(1.0, number(*right) - number(*left));
  Prediction expected;
  expected.state = state_between(frames_[left.value_or(right.value_or(k))].state,
                                 frames_[right.value_or(left.value_or(k))].state, t);
  const auto from = [&](const Pose& pose) {
    Prediction prediction = expected;
    prediction.state.cam_from_head = pose;
    prediction.followed = true;
    return prediction;
  };
  if (forward.solved && backward.solved && same_pose(forward.cam_from_head, backward.cam_from_head))
    return {from(pose_between(forward.cam_from_head, backward.cam_from_head, t))};
  std::vector<Prediction> found;
  if (forward.solved) found.push_back(from(forward.cam_from_head));
  if (backward.solved) found.push_back(from(backward.cam_from_head));
  if (found.empty()) found.push_back(expected);
  return found;
}

std::optional<Gaze> SpanFitter::gaze_of(std::size_t k) const {
  const Vec2d corner(clip_.region.x, clip_.region.y);
  std::array<Vec2d, kLandmarkCount> px;
  for (int p = 0; p < kLandmarkCount; ++p) px[p] = (frames_[k].tracked.landmarks[p] - corner) * clip_.scale;
  return measure_gaze(clip_.frames[k].grey, frames_[k].intrinsics, frames_[k].state.cam_from_head, eyes_, px);
}

// Through a blink the last gaze holds, as in the fit of the clip; training frames are steadied by those
// beside them.
void SpanFitter::look_where(const Indices& changed) {
  std::vector<std::optional<Gaze>> raw(changed.size());
  parallel_for(changed.size(), [&](std::size_t i) { raw[i] = gaze_of(changed[i]); });
  for (std::size_t i = 0; i < changed.size(); ++i) {
    SpanFrame& f = frames_[changed[i]];
    Gaze sum;
    double weight = 0;
    for (int step = f.held_out ? 0 : -1; step <= (f.held_out ? 0 : 1); ++step) {
      const std::ptrdiff_t j = std::ptrdiff_t(i) + step;
      if (j < 0 || j >= std::ptrdiff_t(changed.size()) || !raw[std::size_t(j)] ||
          std::abs(std::ptrdiff_t(changed[std::size_t(j)]) - std::ptrdiff_t(changed[i])) > 1)
        continue;
      const double w = step == 0 ? 2 : 1;
      const Gaze& other = *raw[std::size_t(j)];
      sum.yaw += w * other.yaw, sum.pitch += w * other.pitch, weight += w;
    }
    if (weight > 0) {
      f.tracked.pose.articulation.left_eye = f.tracked.pose.articulation.right_eye =
          eye_rotation({sum.yaw / weight, sum.pitch / weight, 0});
      continue;
    }
    for (std::size_t j = changed[i]; j-- > 0;) {
      if (!frames_[j].usable() || (frames_[j].held_out && !f.held_out)) continue;
      f.tracked.pose.articulation.left_eye = frames_[j].tracked.pose.articulation.left_eye;
      f.tracked.pose.articulation.right_eye = frames_[j].tracked.pose.articulation.right_eye;
      break;
    }
  }
}

Result<void> SpanFitter::fit_training(const Progress& progress, std::stop_token stop) {
  const Indices wanted = targets(false);
  if (wanted.empty()) return {};
  const auto left = anchor(wanted.front(), -1, true), right = anchor(wanted.back(), 1, true);
  if (!left && !right) return {};
  progress.report(0, "how the face looks around the span");
  know_appearance(references(0, true), stop);
  progress.report(0.15, "following the head into it");
  Indices there, back;
  for (std::size_t k = left ? *left + 1 : frames_.size(); k <= wanted.back(); ++k)
    if (!frames_[k].held_out && frames_[k].camera) there.push_back(k);
  for (std::size_t k = right ? *right : 0; k-- > wanted.front();)
    if (!frames_[k].held_out && frames_[k].camera) back.push_back(k);
  std::vector<FollowedFrame> forward(frames_.size()), backward(frames_.size());
  parallel_for(2, [&](std::size_t side) {
    if (side == 0 && left) forward = follow(*left, there, stop);
    if (side == 1 && right) backward = follow(*right, back, stop);
  });
  if (stop.stop_requested()) return cancelled_error();
  progress.report(0.4, "fitting the span's frames");
  std::vector<std::vector<Prediction>> predicted(frames_.size());
  std::vector<std::optional<SpanTry>> tries(frames_.size());
  parallel_for(wanted.size(), [&](std::size_t i) {
    const std::size_t k = wanted[i];
    if (stop.stop_requested()) return;
    predicted[k] = predictions(k, left, right, forward[k], backward[k]);
    tries[k] = best_of(k, predicted[k]);
  });
  for (int round = 0; round < 2; ++round) {
    progress.report(0.6 + 0.15 * round, "settling them on the pictures");
    const std::vector<std::optional<SpanTry>> before = tries;  // any order gives the same
    parallel_for(wanted.size(), [&](std::size_t i) {
      const std::size_t k = wanted[i];
      if (tries[k] && !stop.stop_requested())
        tries[k]->state = settled(k, *before[k], pull_of(k, before), 2 - round);
    });
  }
  if (stop.stop_requested()) return cancelled_error();
  parallel_for(wanted.size(), [&](std::size_t i) {
    const std::size_t k = wanted[i];
    if (tries[k]) decide(k, *tries[k]);
  });
  Indices changed;
  for (const std::size_t k : wanted)
    if (frames_[k].changed) changed.push_back(k);
  look_where(changed);
  progress.report(1);
  return {};
}

// One after the other: each is followed to from the last frame before it that lies well, through all between.
Result<void> SpanFitter::fit_held_out(const Progress& progress, std::stop_token stop) {
  const Indices wanted = targets(true);
  if (wanted.empty()) return {};
  know_appearance(references(wanted.front(), false), stop);
  std::optional<HeadFollower> follower;
  FaceState walked;
  std::size_t from = 0, at = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(double(i) / double(wanted.size()), "fitting held-out frames by themselves");
    const std::size_t k = wanted[i];
    const auto left = anchor(k, -1, false);
    if (!left) continue;
    if (!follower || from != *left) {
      from = at = *left;
      walked = frames_[from].state;
      follower.emplace(rigid_, frames_[from].intrinsics, clip_.frames[from].grey, walked.cam_from_head);
    }
    FollowedFrame followed;
    while (at < k)
      if (frames_[++at].camera) followed = step(*follower, at, walked);
    // The face as it was just before.
    std::size_t last = *left;
    for (std::size_t j = *left; j < k; ++j)
      if (frames_[j].usable()) last = j;
    std::vector<Prediction> predicted = predictions(k, last, {}, followed, {});
    auto found = best_of(k, predicted);
    if (!found) continue;
    const FramePull pull = own_pull(*found);
    for (int round = 0; round < 2; ++round) found->state = settled(k, *found, pull, 2 - round);
    decide(k, *found);
    if (frames_[k].changed) look_where({k});
  }
  progress.report(1);
  return {};
}

// Of those whose neighbours did not change, the pose stays as well.
void SpanFitter::bridge() {
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    SpanFrame& f = frames_[k];
    if (!f.target || f.tracked.status != FrameStatus::lost) continue;
    const auto may_know = [&](std::size_t j) { return f.held_out ? j < k : !frames_[j].held_out; };
    std::vector<TrackedFrame> around;
    bool moved = false;
    for (const int step : {-1, 1})
      for (std::ptrdiff_t j = std::ptrdiff_t(k) + step; j >= 0 && j < std::ptrdiff_t(frames_.size());
           j += step)
        if (const SpanFrame& other = frames_[std::size_t(j)];
            may_know(std::size_t(j)) && other.tracked.status != FrameStatus::lost) {
          around.push_back(other.tracked);
          moved |= other.changed;
          break;
        }
    if (!moved) continue;
    around.push_back(f.tracked);
    std::ranges::sort(around, {}, &TrackedFrame::frame);
    bridge_lost(around);
    f.tracked = *std::ranges::find(around, f.tracked.frame, &TrackedFrame::frame);
  }
}

}  // namespace likeness
