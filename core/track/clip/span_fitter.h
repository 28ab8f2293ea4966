// The work of refit_span: the pictures of a span and around it, with what the track says of them, and every
// step from followed points to verdicts. Internal to refit_span.
#pragma once

#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/scene/track.h"
#include "core/track/clip/refit_options.h"
#include "core/track/clip_frames.h"
#include "core/track/photo/face_look.h"
#include "core/track/photo/gaze.h"
#include "core/track/photo/photometric.h"
#include "core/track/points/follow_head.h"

namespace likeness {

// A frame of the window that was read. Poses are of the head in the camera.
struct SpanFrame {
  TrackedFrame tracked;                    // as it is; a target's changes when a better state is found
  const Camera* camera = nullptr;          // null: unknown
  Pose cam_from_world = Pose::Identity();  // m
  Intrinsics intrinsics;                   // of the working picture
  bool held_out = false, target = false;
  bool changed = false;
  FaceState state;  // of `tracked`
  FaceLook look;    // by its landmarks

  bool usable() const { return camera && tracked.status != FrameStatus::lost; }
};

// Where a face is looked for, and from what the fit starts.
struct Prediction {
  FaceState state;
  bool followed = false;  // the pose comes from points on the head
};

// A state of a frame with what speaks for it. Lengths in working px.
struct SpanTry {
  FaceState state;
  Landmarks landmarks;  // source px
  FaceObservation observation;
  bool followed = false, detected = false;
  double inner_px = 0;  // the model misses the landmarks by this, in the mean
  double look = 1;      // agreement with the good frames around
  double picture = 0;   // robust difference to the picture, of the face's points' spread; 0: not known
  FrameStatus status = FrameStatus::good;
  std::string reason;
};

bool has_landmarks(const TrackedFrame& frame);

class SpanFitter {
 public:
  SpanFitter(const HeadModel& model, const Track& track, const RefitOptions& options, FaceDetector detector,
             double usual_error_px);
  // The window's pictures, with the track's frames of the same numbers. targets: first..last.
  void take(ClipFrames clip, const CameraSet& cameras, const Track& track, const RefitSpan& span);
  // The training frames of the span, from training frames; then the held-out ones, each from what came
  // before.
  Result<void> fit_training(const Progress& progress, std::stop_token stop);
  Result<void> fit_held_out(const Progress& progress, std::stop_token stop);
  // Lost targets lie between their neighbours as they are now.
  void bridge();

  const std::vector<SpanFrame>& frames() const { return frames_; }

 private:
  using Indices = std::vector<std::size_t>;  // of the window

  Indices targets(bool held_out) const;
  std::optional<std::size_t> anchor(std::size_t from, int step, bool training_only) const;
  // One picture further: by points first, then by the face itself. last: its state before, and after.
  FollowedFrame step(HeadFollower& follower, std::size_t k, FaceState& last) const;
  std::vector<FollowedFrame> follow(std::size_t from, const Indices& walk, std::stop_token stop) const;
  std::vector<Prediction> predictions(std::size_t k, std::optional<std::size_t> left,
                                      std::optional<std::size_t> right, const FollowedFrame& forward,
                                      const FollowedFrame& backward) const;
  std::optional<SpanTry> try_at(std::size_t k, const Prediction& prediction) const;
  std::optional<SpanTry> best_of(std::size_t k, const std::vector<Prediction>& predictions) const;
  SpanTry as_tracked(std::size_t k) const;
  Indices references(std::size_t before, bool all) const;
  void know_appearance(const Indices& chosen, std::stop_token stop);
  FramePull own_pull(const SpanTry& found) const;
  FramePull pull_of(std::size_t k, const std::vector<std::optional<SpanTry>>& tries) const;
  FramePull followed_pull(const Prediction& prediction) const;
  FaceState settled(std::size_t k, const SpanTry& found, const FramePull& pull, int first_level) const;
  void measure(std::size_t k, SpanTry& found) const;
  void judge(std::size_t k, SpanTry& found) const;
  bool is_better(const SpanTry& found, const SpanTry& before) const;
  // Takes what is better.
  void decide(std::size_t k, SpanTry found);
  std::optional<Gaze> gaze_of(std::size_t k) const;
  void look_where(const Indices& changed);

  const RefitOptions options_;
  const FaceDetector detector_;
  const double usual_px_, metres_per_unit_;
  HeadShape shape_;
  ReducedHead head_;
  ReducedPerson person_;
  ExpressionPrior prior_;
  RigidHead rigid_;
  EyeBalls eyes_;
  FaceSurface surface_;
  ClipFrames clip_;
  int spacing_ = 1;  // of the track's frames (frame_spacing.h)
  std::vector<SpanFrame> frames_;
  std::optional<Appearance> appearance_;
};

}  // namespace likeness
