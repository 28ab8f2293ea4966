// What is known of a clip while it is tracked, and the steps that gather evidence for its fits. Internal to
// track_clip.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/face/fit_clip.h"
#include "core/head/pose_head.h"
#include "core/scene/track.h"
#include "core/track/clip_frames.h"
#include "core/track/photo/gaze.h"
#include "core/track/photo/lids.h"
#include "core/track/points/dense_head.h"
#include "core/track/points/optical_support.h"
#include "core/track/track_options.h"

namespace likeness {

inline constexpr int kIdentityDirections = 60;  // landmarks say nothing about the finer ones

// Everything known of the clip while it is fitted; one entry a decoded frame in each array.
struct ClipWork {
  ClipFrames clip;
  int spacing = 1;                     // of the clip's frames (frame_spacing.h)
  std::vector<const Camera*> cameras;  // null: unknown
  std::vector<Intrinsics> intrinsics;  // of the working pictures
  std::vector<FaceFrame> faces;
  std::vector<DenseFrame> dense;
  std::vector<std::optional<Gaze>> gaze;
  std::vector<OpticalVerdict> optical;  // empty before the landmarks were followed
  std::vector<LidOpenings> lids;        // by the pixels; empty before they were read
  RestChoice rest;                      // frames of the resting face; empty before they were chosen
  std::vector<double> look;             // agreement with the person's other frames; empty before it is known
  ReducedHead head;
  ExpressionPrior prior;
  Eigen::VectorXd identity;
  Eigen::VectorXf fine_identity;  // the model's further directions, of a person who is given; empty: none
  std::vector<HeadPoint> points;  // of the dense step
  std::vector<Vec3f> offsets;     // the personal shape, part of `head`; empty before it is known

  HeadShape shape(const HeadModel& model) const {
    return shape_head(model, PersonShape{full_identity(model), offsets});
  }
  Eigen::VectorXf full_identity(const HeadModel& model) const {
    Eigen::VectorXf full = Eigen::VectorXf::Zero(model.identity_count());
    full.head(identity.size()) = identity.cast<float>();
    if (fine_identity.size() > 0) full.tail(fine_identity.size()) = fine_identity;
    return full;
  }
};

// An empty fit of the clip's frames, with their cameras and landmarks.
void prepare(const CameraSet& cameras, const HeadModel& model, ClipWork& work);

// Landmarks again, started from where the dense pose says the face is: a bowed head shifts the detector's
// box, and with it the mouth, by a whole lip.
Result<void> find_landmarks_again(const TrackOptions& options, ClipWork& work, const Progress& progress,
                                  std::stop_token stop);
// Neighbouring frames vote on the landmarks, and every face is compared with what it looks like elsewhere.
Result<void> cross_check(ClipWork& work, const Progress& progress, std::stop_token stop);
// Brows raised so high that the predictor loses them are found by what they look like.
Result<void> find_lost_brows(ClipWork& work, std::stop_token stop);
// How far the lids are open, by the pixels; evidence for every fit from here on.
Result<void> watch_lids(const HeadModel& model, ClipWork& work, std::stop_token stop);
// Which training frames show the person at rest (choose_rest.h), by landmarks and lids as they are now; the
// fits' frames are marked accordingly.
void find_rest(const TrackOptions& options, ClipWork& work);
// Leaves out those found in which the lips are further apart than in the others, by the pixels.
void leave_out_parted(ClipWork& work);
// Where the eyes look.
Result<void> measure_eyes(const HeadModel& model, ClipWork& work, const Progress& progress,
                          std::stop_token stop);

// The fitted frames as a track holds them, each with its verdict; lost ones are bridged.
std::vector<TrackedFrame> describe_frames(const ClipWork& work, const HeadModel& model,
                                          double metres_per_unit);

}  // namespace likeness
