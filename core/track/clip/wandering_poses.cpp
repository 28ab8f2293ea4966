// The mean of what the fitted face's inner landmarks are off, as a vector: expressions and noise cancel in
// it.
#include "core/track/clip/wandering_poses.h"

#include <vector>

#include "core/base/quantile.h"

namespace likeness {
namespace {

// By how much the fitted face lies beside the landmarks, all of them in one direction, as a share of the
// distance between the outer corners of the eyes.
double drift_off_landmarks(const ClipWork& work, const ReducedPerson& person, const FaceFrame& face) {
  constexpr int kRightEye = 36, kLeftEye = 45;
  const FaceObservation& seen = face.observation;
  Vec2d off = Vec2d::Zero();
  for (int i = kJawLineCount; i < kLandmarkCount; ++i)
    off += Vec2d((face.state.cam_from_head *
                  reduced_point(work.head, person, i, face.state.expression, face.state.jaw))
                     .hnormalized()) -
           seen.rays[i];
  const double eyes = (seen.rays[kRightEye] - seen.rays[kLeftEye]).norm();
  return eyes > 0 ? (off / (kLandmarkCount - kJawLineCount)).norm() / eyes : 0;
}

}  // namespace

bool drop_wandering_poses(ClipWork& work) {
  // Of the eyes' distance.
  constexpr double kFrameWanders = 0.03, kClipWanders = 0.008;
  const ReducedPerson person = reduced_person(work.head, work.identity);
  std::vector<double> drifts(work.faces.size(), 0), teaching;
  for (std::size_t i = 0; i < work.faces.size(); ++i) {
    const FaceFrame& face = work.faces[i];
    if (!face.seen || !face.pose_given) continue;
    drifts[i] = drift_off_landmarks(work, person, face);
    if (!face.held_out) teaching.push_back(drifts[i]);
  }
  const bool every = !teaching.empty() && median(std::move(teaching)) > kClipWanders;
  bool any = false;
  for (std::size_t i = 0; i < work.faces.size(); ++i) {
    if (!work.faces[i].pose_given || !(every || drifts[i] > kFrameWanders)) continue;
    work.faces[i].pose_given = false;
    work.dense[i].solved = false;
    any = true;
  }
  return any;
}

}  // namespace likeness
