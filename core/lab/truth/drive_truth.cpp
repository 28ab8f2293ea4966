// Correlation, jitter and the picture at rest: see drive_truth.h.
#include "core/lab/truth/drive_truth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/head/action_amounts.h"
#include "core/image/metrics.h"
#include "core/render/pose_avatar.h"
#include "core/render/render.h"

namespace likeness {
namespace {

constexpr double kSame_db = 99;

double second_difference(const std::vector<double>& curve) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < curve.size(); ++i)
    sum += std::pow(curve[i - 1] - 2 * curve[i] + curve[i + 1], 2);
  return curve.size() > 2 ? std::sqrt(sum / double(curve.size() - 2)) : 0;
}

// The picture that a driver at rest in the typical pose gives, against the avatar's own neutral.
Result<void> compare_rest(const Avatar& avatar, const HeadModel& avatar_model, const DriveSubject& driver,
                          const DriveSubject& subject, const DriveOptions& options, DriveScore& score) {
  Track rest;
  rest.head_model_name = driver.model->name;
  rest.head_model_hash = driver.model->hash;
  rest.person = driver.person;
  rest.neutral = driver.neutral;
  TrackedFrame frame;
  frame.pose.articulation = driver.neutral;
  frame.pose.world_from_head = driver.world_from_head;
  rest.frames = {frame};
  const auto driven = drive(rest, driver, subject, options);
  if (!driven) return driven.error();
  const auto made = make_rig(avatar, avatar_model);
  if (!made) return made.error();
  const AvatarRig& rig = *made;
  const auto picture = [&](const AvatarPose& pose) {
    const RenderedFrame rendered = render_frame(avatar, typical_camera(avatar), pose_avatar(rig, pose));
    return to_bytes(composite(rendered.rgba, Image8{}));
  };
  const Image8 own = picture(typical_state(avatar).pose);
  const Image8 other = picture(driven->front().pose);
  for (std::size_t i = 0; i < own.data.size(); ++i)
    score.neutral_difference = std::max(score.neutral_difference, std::abs(own.data[i] - other.data[i]));
  const double error = mse(to_float(own), to_float(other));
  score.neutral_psnr_db = error > 0 ? std::min(kSame_db, psnr_from_mse(error)) : kSame_db;
  return {};
}

}  // namespace

Result<DriveScore> score_drive(const Avatar& avatar, const HeadModel& avatar_model, const Track& track,
                               const HeadModel& driver_model, const TrackTruth& truth,
                               const DriveOptions& options) {
  const DriveSubject subject = avatar_subject(avatar, avatar_model);
  const auto driver = subject_from_track(track, driver_model);
  if (!driver) return driver.error();
  const auto driven = drive(track, *driver, subject, options);
  if (!driven) return driven.error();
  DriveScore score;
  score.frames = int(driven->size());
  const ActionBasis avatar_basis = action_basis(avatar_model), driver_basis = action_basis(driver_model),
                    truth_basis = action_basis(truth.model);
  const std::vector<float> gains = drive_gains(*driver, subject, options);
  std::vector<Eigen::VectorXf> shown, tracked, performed;
  for (std::size_t i = 0; i < driven->size(); ++i) {
    score.bridged += (*driven)[i].bridged;
    const TrackedFrame* true_frame = find_tracked(truth.track, (*driven)[i].frame);
    if ((*driven)[i].bridged || true_frame == nullptr) continue;
    shown.push_back(face_amounts(avatar_basis, (*driven)[i].pose.articulation));
    tracked.push_back(face_amounts(driver_basis, track.frames[i].pose.articulation));
    performed.push_back(face_amounts(truth_basis, true_frame->pose.articulation));
  }
  double sum = 0;
  int counted = 0;
  for (const std::string& name : compared_actions()) {
    const int a = action_index(avatar_basis, name), d = action_index(driver_basis, name),
              t = action_index(truth_basis, name);
    if (a < 0 || d < 0 || t < 0) continue;
    std::vector<double> avatar_curve, driver_curve, true_curve;
    for (std::size_t i = 0; i < shown.size(); ++i) {
      avatar_curve.push_back(shown[i][a]);
      driver_curve.push_back(tracked[i][d]);
      true_curve.push_back(performed[i][t]);
    }
    DrivenAction action{name, course_correlation(true_curve, avatar_curve), double(gains[std::size_t(a)])};
    const double before = second_difference(driver_curve);
    action.jitter_ratio = before > 0 ? second_difference(avatar_curve) / before : 1;
    if (action.correlation) sum += *action.correlation, ++counted;
    score.actions.push_back(std::move(action));
  }
  score.mean_correlation = counted > 0 ? sum / counted : 0;
  if (const auto rest = compare_rest(avatar, avatar_model, *driver, subject, options, score); !rest)
    return rest.error();
  return score;
}

}  // namespace likeness
