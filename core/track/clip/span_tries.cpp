// The tries at one frame of a span - landmarks sought, the face fitted and settled on the picture - and what
// decides between them and what the frame had: see span_fitter.h.
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/face/observe_face.h"
#include "core/track/clip/frame_verdict.h"
#include "core/track/clip/span_fitter.h"

namespace likeness {
namespace {

constexpr double kFollowedTurn = 100, kFollowedShift = 300;  // pulls to a followed pose, per rad and m
constexpr double kGuessedTurn = 40, kGuessedShift = 100;     // to one between or beyond the anchors
constexpr double kClearShare = 0.4, kMostDoubt = 5;          // share of runs; times sigma
constexpr double kFacePull = 2;                              // to the expression expected, per unit
constexpr double kSameFace = 0.3;      // overlap of the detector's box with the expected one
constexpr double kUnlikeOthers = 0.4;  // unlike the face elsewhere: judge_frame's own limit
constexpr int kFewLooks = 4, kFewPictures = 5;
constexpr int kNearFrames = 3;  // that were read: a neighbour in time that steadies
// What is equal in verdict must be nearer by this to be taken: of noise alone nothing changes.
constexpr double kNearerGood = 0.7, kNearerWeak = 0.95, kSamePicture = 1.02;
// Plainly more like the face elsewhere: then landmarks, which jump where the net did, may say a little less.
constexpr double kLikerPicture = 0.85, kLittleFarther = 1.5;

}  // namespace

bool has_landmarks(const TrackedFrame& frame) {
  return std::ranges::any_of(frame.landmarks, [](const Vec2d& p) { return p != Vec2d::Zero(); });
}

FramePull SpanFitter::followed_pull(const Prediction& prediction) const {
  FramePull pull;
  pull.cam_from_head = prediction.state.cam_from_head;
  pull.turn_weight = prediction.followed ? kFollowedTurn : kGuessedTurn;
  pull.shift_weight = prediction.followed ? kFollowedShift : kGuessedShift;
  pull.expression = prediction.state.expression, pull.jaw = prediction.state.jaw;
  pull.expression_weight = kFacePull, pull.jaw_weight = 2 * kFacePull;
  return pull;
}

std::optional<SpanTry> SpanFitter::try_at(std::size_t k, const Prediction& prediction) const {
  const SpanFrame& f = frames_[k];
  const Image8& grey = clip_.frames[k].grey;
  const ExpectedFace face = expect_face(head_, person_, f.intrinsics, prediction.state.cam_from_head);
  const FaceBox& box = face.box;
  if (!(box.width > 20) || box.x + box.width < 0 || box.y + box.height < 0 || box.x > grey.width ||
      box.y > grey.height)
    return std::nullopt;
  SpanTry found;
  found.landmarks = detector_.landmarks(grey, box, 0, &face.hint, {options_.runs, options_.runs});
  const Vec2d corner(clip_.region.x, clip_.region.y);
  for (int p = 0; p < kLandmarkCount; ++p) {
    found.landmarks.points[p] = found.landmarks.points[p] / clip_.scale + corner;
    found.landmarks.spread[p] /= clip_.scale;
  }
  found.observation =
      observe_face(found.landmarks, f.camera->intrinsics, clip_.scale, f.intrinsics.fx, found.observation);
  found.followed = prediction.followed;
  if (!found.followed)
    for (const FaceBox& seen : detector_.detect(grey, &box)) found.detected |= overlap(seen, box) > kSameFace;
  // The spread of few runs that agree is none: what is said by so few is doubted.
  const double doubt =
      std::clamp(kClearShare / std::max(1e-3, found.landmarks.cluster_share), 1.0, kMostDoubt);
  for (double& s : found.observation.sigma_px) s *= doubt;
  found.state =
      fit_frame(head_, person_, found.observation, prior_, followed_pull(prediction), {}, prediction.state);
  measure(k, found);
  // Landmarks can be drawn into any picture: something else must speak for a face.
  if (!found.followed && !found.detected && found.look < kUnlikeOthers) return std::nullopt;
  return found;
}

std::optional<SpanTry> SpanFitter::best_of(std::size_t k, const std::vector<Prediction>& predictions) const {
  std::optional<SpanTry> best;
  const auto cost = [&](const SpanTry& t) {
    return t.inner_px + t.picture + usual_px_ * (1 - t.landmarks.cluster_share) +
           2 * usual_px_ * (1 - t.look);
  };
  for (const Prediction& prediction : predictions)
    if (auto found = try_at(k, prediction); found && (!best || cost(*found) < cost(*best)))
      best = std::move(found);
  return best;
}

// What the track has, as a try like any other. Only for frames with landmarks.
SpanTry SpanFitter::as_tracked(std::size_t k) const {
  const SpanFrame& f = frames_[k];
  SpanTry was;
  was.state = f.state;
  was.landmarks.points = f.tracked.landmarks;
  was.landmarks.spread = f.tracked.landmark_spread;
  was.landmarks.cluster_share = 1;  // not written down; the verdict has it
  was.observation =
      observe_face(was.landmarks, f.camera->intrinsics, clip_.scale, f.intrinsics.fx, was.observation);
  was.followed = true;
  return was;
}

// Good training frames outside the span that frame `before` may know: all of them, or those before it.
SpanFitter::Indices SpanFitter::references(std::size_t before, bool all) const {
  Indices found;
  for (std::size_t k = 0; k < frames_.size() && (all || k < before); ++k)
    if (!frames_[k].target && !frames_[k].held_out && frames_[k].usable() &&
        frames_[k].tracked.status == FrameStatus::good)
      found.push_back(k);
  return found;
}

void SpanFitter::know_appearance(const Indices& chosen, std::stop_token stop) {
  appearance_.reset();
  if (int(chosen.size()) < kFewPictures) return;
  std::vector<PhotometricFrame> pictures(frames_.size());
  std::vector<FaceFrame> faces(frames_.size());
  for (const std::size_t k : chosen) {
    pictures[k] = {&clip_.frames[k].grey, frames_[k].intrinsics,
                   frames_[k].cam_from_world.linear().transpose()};
    faces[k].state = frames_[k].state;
  }
  appearance_ = find_appearance(surface_, head_, person_, pictures, faces, chosen, stop);
}

// Held where it is, as loosely as a pose of landmarks and a face of one picture are known.
FramePull SpanFitter::own_pull(const SpanTry& found) const {
  const PhotometricOptions usual;
  FramePull pull;
  pull.cam_from_head = found.state.cam_from_head;
  pull.turn_weight = usual.hold_among_dense * usual.turn_hold;
  pull.shift_weight = usual.hold_among_dense * usual.shift_hold;
  pull.expression = found.state.expression, pull.jaw = found.state.jaw;
  pull.expression_weight = usual.own_hold, pull.jaw_weight = 2 * usual.own_hold;
  return pull;
}

// Towards the training frames just before and after: their mean expression, and half way to the pose between
// them.
FramePull SpanFitter::pull_of(std::size_t k, const std::vector<std::optional<SpanTry>>& tries) const {
  const PhotometricOptions usual;
  FramePull pull = own_pull(*tries[k]);
  struct Neighbour {
    const FaceState* state;
    double away;
  };
  std::vector<Neighbour> near;
  for (const int step : {-1, 1})
    for (std::ptrdiff_t j = std::ptrdiff_t(k) + step; j >= 0 && j < std::ptrdiff_t(frames_.size());
         j += step) {
      const SpanFrame& f = frames_[std::size_t(j)];
      const double away = std::abs(f.tracked.frame - frames_[k].tracked.frame);
      if (f.held_out) continue;
      if (away <= kNearFrames * spacing_ && (f.target ? tries[std::size_t(j)].has_value() : f.usable()))
        near.push_back({f.target ? &tries[std::size_t(j)]->state : &f.state, away});
      break;
    }
  if (near.empty()) return pull;
  pull.expression.setZero(head_.expression_count());
  pull.jaw = 0;
  for (const Neighbour& n : near)
    pull.expression += n.state->expression / double(near.size()),
        pull.jaw += n.state->jaw / double(near.size());
  pull.expression_weight = usual.expression_change * std::sqrt(double(near.size()));
  pull.jaw_weight = 2 * pull.expression_weight;
  if (near.size() == 2)
    pull.cam_from_head = pose_between(pull.cam_from_head,
                                      pose_between(near[0].state->cam_from_head, near[1].state->cam_from_head,
                                                   near[0].away / (near[0].away + near[1].away)),
                                      0.5);
  return pull;
}

FaceState SpanFitter::settled(std::size_t k, const SpanTry& found, const FramePull& pull,
                              int first_level) const {
  const SpanFrame& f = frames_[k];
  if (!appearance_) return fit_frame(head_, person_, found.observation, prior_, pull, {}, found.state);
  const PhotometricOptions usual;
  FaceObservation observation = found.observation;
  for (double& s : observation.sigma_px) s *= usual.landmark_sigma_factor;
  const FacePicture picture = face_picture(clip_.frames[k].grey, f.intrinsics);
  const FrameEvidenceTerms terms{head_,        person_, observation,
                                 prior_,       pull,    surface_,
                                 *appearance_, picture, f.cam_from_world.linear().transpose(),
                                 usual.weight};
  FaceState state = found.state;
  for (int level = first_level; level >= first_level - 1; --level)
    state = refine_state(terms, level, 4, state);
  return state;
}

void SpanFitter::measure(std::size_t k, SpanTry& found) const {
  const SpanFrame& f = frames_[k];
  const Image8& grey = clip_.frames[k].grey;
  found.inner_px = inner_error(head_, person_, found.observation, found.state);
  const Vec2d corner(clip_.region.x, clip_.region.y);
  std::array<Vec2d, kLandmarkCount> px;
  for (int p = 0; p < kLandmarkCount; ++p) px[p] = (found.landmarks.points[p] - corner) * clip_.scale;
  const FaceLook look = face_look(grey, px);
  std::vector<double> agreement;
  for (const std::size_t r : references(k, !f.held_out))
    if (!frames_[r].look.values.empty()) agreement.push_back(alike(look, frames_[r].look));
  found.look = look.values.empty() ? 0 : 1;
  if (int(agreement.size()) >= kFewLooks && !look.values.empty()) {
    std::ranges::sort(agreement, std::greater<>());
    agreement.resize((agreement.size() + 3) / 4);
    found.look = 0;
    for (const double a : agreement) found.look += a / double(agreement.size());
  }
  if (!appearance_) return;
  const FacePicture picture = face_picture(grey, f.intrinsics);
  const FaceTarget target = face_target(surface_, *appearance_, picture, 1, surface_.fine,
                                        f.cam_from_world.linear().transpose(), found.state);
  FrameSystem cost;
  add_photometric(surface_, picture, target, 1, found.state, &cost);
  found.picture = target.point.empty() ? 1e9 : cost.cost / double(target.point.size());
}

void SpanFitter::judge(std::size_t k, SpanTry& found) const {
  FrameEvidence evidence;
  evidence.camera_known = frames_[k].camera != nullptr;
  evidence.seen = true;
  evidence.detected = found.detected;
  evidence.dense_solved = found.followed;
  evidence.source_px = 1 / clip_.scale;
  evidence.inner_error_px = found.inner_px;
  evidence.cluster_share = found.landmarks.cluster_share;
  evidence.spread = inner_spread(found.landmarks) /
                    std::max(1.0, (found.landmarks.points[36] - found.landmarks.points[45]).norm());
  evidence.look = found.look;
  const FrameVerdict verdict = judge_frame(evidence, usual_px_);
  found.status = verdict.status, found.reason = verdict.reason;
}

bool SpanFitter::is_better(const SpanTry& found, const SpanTry& before) const {
  if (found.status == FrameStatus::lost || found.look < kUnlikeOthers) return false;
  if (before.status == FrameStatus::lost) return true;
  if (found.status != before.status)
    return found.status < before.status && found.picture <= kSamePicture * before.picture;
  const double nearer = found.status == FrameStatus::good ? kNearerGood : kNearerWeak;
  if (found.picture < kLikerPicture * before.picture)
    return found.inner_px < kLittleFarther * before.inner_px;
  return found.inner_px < nearer * before.inner_px && found.picture <= kSamePicture * before.picture;
}

void SpanFitter::decide(std::size_t k, SpanTry found) {
  SpanFrame& f = frames_[k];
  measure(k, found);
  judge(k, found);
  SpanTry before;
  before.status = FrameStatus::lost;
  if (f.tracked.status != FrameStatus::lost && has_landmarks(f.tracked)) {
    before = as_tracked(k);
    measure(k, before);
    judge(k, before);
    before.status = std::max(before.status, f.tracked.status);
  }
  if (!is_better(found, before)) return;
  f.changed = true;
  f.state = found.state;
  TrackedFrame& out = f.tracked;
  out.status = found.status, out.reason = found.reason;
  out.pose.world_from_head = inverse(f.cam_from_world) * found.state.cam_from_head;
  out.pose.articulation.expression = found.state.expression.cast<float>();
  out.pose.articulation.jaw = Vec3f(float(found.state.jaw), 0, 0);
  out.landmarks = found.landmarks.points;
  out.landmark_spread = found.landmarks.spread;
  out.look = found.look;
  out.inner_error_px = found.inner_px / clip_.scale;
}

}  // namespace likeness
