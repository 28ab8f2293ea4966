// From fitted frames to a track's: see clip_work.h.
#include <algorithm>
#include <cmath>

#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/track/clip/clip_work.h"
#include "core/track/clip/frame_verdict.h"
#include "core/track/points/camera_scale.h"

namespace likeness {
namespace {

// What the verdict on a frame rests on.
FrameEvidence evidence_of(const ClipWork& work, std::size_t i, const TrackedFrame& tracked) {
  const ClipFrame& source = work.clip.frames[i];
  FrameEvidence e;
  e.in_shot = source.shot >= 0;
  e.camera_known = work.cameras[i] != nullptr;
  e.seen = work.faces[i].seen;
  e.detected = source.detected;
  e.dense_solved = work.dense[i].solved;
  e.source_px = 1 / work.clip.scale;
  e.inner_error_px = tracked.inner_error_px * work.clip.scale;
  if (source.landmarks) {
    const double eyes = (source.landmarks->points[36] - source.landmarks->points[45]).norm();
    e.eyes_px = eyes * work.clip.scale;
    e.cluster_share = source.landmarks->cluster_share;
    e.spread = inner_spread(*source.landmarks) / std::max(1.0, eyes);
  }
  if (!work.optical.empty()) {
    e.votes = work.optical[i].votes;
    e.disagreement_px = work.optical[i].disagreement_px * work.clip.scale;
    e.carried = work.optical[i].carried;
  }
  if (!work.look.empty()) e.look = work.look[i];
  return e;
}

}  // namespace

std::vector<TrackedFrame> describe_frames(const ClipWork& work, const HeadModel& model,
                                          double metres_per_unit) {
  const ReducedPerson person = reduced_person(work.head, work.identity);
  std::vector<TrackedFrame> frames(work.faces.size());
  std::vector<double> errors;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    TrackedFrame& out = frames[i];
    const FaceFrame& face = work.faces[i];
    out.frame = face.frame;
    out.time_s = work.clip.frames[i].time_s;
    out.pose.articulation = neutral_articulation(model);
    out.landmarks.fill(Vec2d::Zero());
    if (!face.seen) continue;
    out.landmarks = work.clip.frames[i].landmarks->points;
    if (!work.look.empty()) out.look = work.look[i];
    out.landmark_spread = work.clip.frames[i].landmarks->spread;
    out.inner_error_px = inner_error(work.head, person, face.observation, face.state) / work.clip.scale;
    if (!face.held_out) errors.push_back(out.inner_error_px * work.clip.scale);
    out.pose.articulation.expression = face.state.expression.cast<float>();
    out.pose.articulation.jaw.x() = static_cast<float>(face.state.jaw);
    if (work.gaze[i])
      out.pose.articulation.left_eye = out.pose.articulation.right_eye = eye_rotation(*work.gaze[i]);
    const Pose world_from_cam = inverse(metric_camera(work.cameras[i]->cam_from_world, metres_per_unit));
    out.pose.world_from_head = world_from_cam * face.state.cam_from_head;
  }
  const double usual = median(errors);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameVerdict verdict = judge_frame(evidence_of(work, i, frames[i]), usual);
    frames[i].status = verdict.status;
    frames[i].reason = verdict.reason;
  }
  std::vector<bool> held_out;
  std::vector<int> shots;
  for (const FaceFrame& face : work.faces) held_out.push_back(face.held_out), shots.push_back(face.shot);
  bridge_lost(frames, held_out, shots);
  return frames;
}

}  // namespace likeness
