// A clip carried over: see drive.h.
#include "core/drive/drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/drive/drive_map.h"
#include "core/head/action_amounts.h"
#include "core/head/pose_head.h"
#include "core/render/avatar.h"
#include "core/track/fit/neutral.h"

namespace likeness {
namespace {

constexpr double kMetresPerRadian = 0.17;  // a turn of ten degrees counts as 3 cm
constexpr float kWorthCalibrating = 0.15f, kGainDeadZone = 1.1f, kMinGain = 0.75f, kLargestGain = 1.33f;

void bridge_gaps(std::vector<DriverMotion>& motions, const Track& track) {
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < motions.size(); ++i)
    if (!motions[i].bridged) known.push_back(i);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (!motions[i].bridged) continue;
    const auto after = std::ranges::lower_bound(known, i);
    const std::size_t b = after == known.end() ? known.back() : *after;
    const std::size_t a = after == known.begin() ? known.front() : *(after - 1);
    const double span = track.frames[b].time_s - track.frames[a].time_s;
    const double t = b > a && span > 0 ? (track.frames[i].time_s - track.frames[a].time_s) / span : 0;
    motions[i] = between(motions[a], motions[b], std::clamp(t, 0.0, 1.0));
  }
}

// Each curve filtered by a binomial window of five frames (weights 1 4 6 4 1), which has no lag; the ends are
// held.
std::vector<Eigen::VectorXf> without_tremor(const std::vector<Eigen::VectorXf>& courses) {
  constexpr std::array kWeights{1.0f, 4.0f, 6.0f, 4.0f, 1.0f};
  const int n = int(courses.size());
  std::vector<Eigen::VectorXf> steady(courses.size());
  for (int i = 0; i < n; ++i) {
    Eigen::VectorXf sum = Eigen::VectorXf::Zero(courses[std::size_t(i)].size());
    for (int k = 0; k < 5; ++k)
      sum += kWeights[std::size_t(k)] * courses[std::size_t(std::clamp(i + k - 2, 0, n - 1))];
    steady[std::size_t(i)] = sum / 16;
  }
  return steady;
}

Result<void> check(const Track& track, const DriveSubject& driver, const DriveSubject& avatar,
                   const DriveOptions& options) {
  if (track.head_model_hash != driver.model->hash) {
    return Error{ErrorCode::bad_input,
                 fmt::format("The driving track was made with the {} head model, not with the {} one.",
                             track.head_model_name, driver.model->name),
                 "Name the track's own head model, or track the clip again.", "drive"};
  }
  if (!std::ranges::all_of(track.frames, [&](const TrackedFrame& frame) {
        return frame.pose.articulation.expression.size() == driver.model->expression_count();
      })) {
    return Error{ErrorCode::bad_input, "Track, avatar and head models differ in their number of expressions.",
                 "Track the clip again, and train the avatar again if that does not help.", "drive"};
  }
  if (std::ranges::all_of(track.frames,
                          [](const TrackedFrame& f) { return f.status == FrameStatus::lost; })) {
    return Error{ErrorCode::no_face, "The face is lost in every frame of the driving track.",
                 "Use a driving clip in which the face is close and well lit.", "drive"};
  }
  return check_drive(driver, avatar, options);
}

}  // namespace

Result<DriveSubject> subject_from_track(const Track& track, const HeadModel& model) {
  DriveSubject subject;
  subject.model = &model;
  subject.person = track.person;
  std::vector<const TrackedFrame*> frames;
  for (const TrackedFrame& frame : track.frames)
    if (frame.status != FrameStatus::lost &&
        frame.pose.articulation.expression.size() == model.expression_count())
      frames.push_back(&frame);
  if (frames.empty()) {
    return Error{ErrorCode::no_face, "The face is lost in every frame of the driving track.",
                 "Use a driving clip in which the face is close and well lit.", "drive"};
  }
  subject.neutral = track.neutral.expression.size() == model.expression_count()
                        ? track.neutral
                        : calibrate_neutral(model, track.frames, {});
  const ActionBasis basis = action_basis(model);
  std::vector<std::vector<float>> amounts(basis.actions.size());
  for (const TrackedFrame* frame : frames) {
    const Eigen::VectorXf own = action_amounts(basis, frame->pose.articulation);
    for (std::size_t a = 0; a < amounts.size(); ++a) amounts[a].push_back(own[Eigen::Index(a)]);
  }
  for (std::size_t a = 0; a < amounts.size(); ++a)
    subject.seen.push_back({basis.actions[a].name, quantile(amounts[a], 0.02), quantile(amounts[a], 0.98)});
  // Medoid of the poses, among up to 200 frames.
  const std::size_t stride = std::max<std::size_t>(1, frames.size() / 200);
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < frames.size(); i += stride) {
    double sum = 0;
    for (std::size_t j = 0; j < frames.size(); j += stride) {
      const Pose difference = inverse(frames[i]->pose.world_from_head) * frames[j]->pose.world_from_head;
      sum +=
          difference.translation().norm() + kMetresPerRadian * vector_from_turn(difference.linear()).norm();
    }
    if (sum < best) best = sum, subject.world_from_head = frames[i]->pose.world_from_head;
  }
  return subject;
}

DriveSubject avatar_subject(const Avatar& avatar, const HeadModel& model) {
  DriveSubject subject;
  subject.model = &model;
  subject.person = avatar.person;
  subject.neutral = avatar.neutral;
  for (const ActionRange& range : avatar.seen) subject.seen.push_back({range.name, range.low, range.high});
  subject.world_from_head = avatar.world_from_head;
  subject.world_from_torso = avatar.world_from_torso;
  return subject;
}

std::vector<float> drive_gains(const DriveSubject& driver, const DriveSubject& avatar,
                               const DriveOptions& options) {
  const ActionBasis basis = action_basis(*avatar.model), other = action_basis(*driver.model);
  const Eigen::VectorXf rest = action_amounts(basis, avatar.neutral);
  const Eigen::VectorXf driver_rest = action_amounts(other, driver.neutral);
  std::vector<float> gains;
  for (std::size_t a = 0; a < basis.actions.size(); ++a) {
    const NamedAction& action = basis.actions[a];
    float gain = 1;
    const SeenAction *mine = find_seen(avatar.seen, action.name),
                     *theirs = find_seen(driver.seen, action.name);
    const int d = action_index(other, action.name);
    const bool gaze = !action.left_eye.isZero() || !action.right_eye.isZero();  // an angle is an angle
    if (options.calibrate_gains && !gaze && mine && theirs && d >= 0) {
      const float to = mine->high - rest[Eigen::Index(a)], from = theirs->high - driver_rest[d];
      if (to > kWorthCalibrating && from > kWorthCalibrating) {
        const float ratio = to / from;
        if (ratio > kGainDeadZone) gain = std::min(ratio / kGainDeadZone, kLargestGain);
        if (ratio < 1 / kGainDeadZone) gain = std::max(ratio * kGainDeadZone, kMinGain);
      }
    }
    const auto user = options.gains.find(action.name);
    gains.push_back(user == options.gains.end() ? gain : gain * user->second);
  }
  return gains;
}

Result<std::vector<DrivenFrame>> drive(const Track& track, const DriveSubject& driver,
                                       const DriveSubject& avatar, const DriveOptions& options) {
  if (const auto checked = check(track, driver, avatar, options); !checked) return checked.error();
  const Vec3d driver_neck = neck_of(driver);
  std::vector<DriverMotion> motions;
  std::vector<double> steps_s;
  for (std::size_t i = 0; i < track.frames.size(); ++i) {
    motions.push_back(motion_of(track.frames[i], driver, driver_neck));
    const double step = i > 0 ? track.frames[i].time_s - track.frames[i - 1].time_s : 0.04;
    steps_s.push_back(step > 1e-4 && step < 1 ? step : 0.04);
  }
  bridge_gaps(motions, track);
  if (options.smooth) {
    MotionFilter filter;
    for (std::size_t i = 0; i < motions.size(); ++i)
      motions[i] = filter.next(std::move(motions[i]), steps_s[i]);
  }

  const FaceMap face(driver, avatar, options);
  std::vector<Eigen::VectorXf> amounts;
  for (const DriverMotion& motion : motions) amounts.push_back(face.amounts(motion));
  const std::vector<Eigen::VectorXf> steady = without_tremor(amounts);
  HeadMap head(driver, avatar, options);
  std::vector<DrivenFrame> driven;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    DrivenFrame frame;
    frame.frame = track.frames[i].frame, frame.time_s = track.frames[i].time_s;
    frame.bridged = motions[i].bridged;
    frame.pose.articulation = face.articulation(motions[i], amounts[i], steady[i]);
    head.place(motions[i], steps_s[i], frame);
    driven.push_back(std::move(frame));
  }
  return driven;
}

}  // namespace likeness
