// Fits one identity to the training frames of a clip, then pose, expression and jaw of every frame.
//
// Held-out frames influence nothing shared: they take no part in the identity, are never a temporal neighbour
// of a training frame, and are themselves pulled only towards the frame before them.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/face/fit_frame.h"

namespace likeness {

struct FaceFrame {
  int frame = 0;      // number in the source
  bool seen = false;  // has landmarks
  bool held_out = false;
  int shot = 0;             // frames of different ones are no neighbours: the film was cut between them
  bool pose_given = false;  // the pose is held: dense tracks are more accurate than landmarks
  FaceObservation observation;
  FaceState state;    // guess in, fit out
  bool rest = false;  // shows the person's resting face: what it shows is identity
};

struct ClipFitOptions {
  int identity_frames = 100;  // at most this many, spread evenly; cost of the identity fit is linear in it
  double identity_weight =
      6;  // prior per standard deviation at 100 frames, grows with the root of the frames
  double joint_expression = 2.5;  // times the expression prior while the identity is fitted: what a face
                                  // shows in every frame is its shape, no constant expression
  double expression_change = 4;   // first difference, per unit
  double turn_change = 60;        // second difference, per rad
  double shift_change = 150;      // second difference, per m
  bool hold_identity = false;     // fit_identity finds only the registration
  int spacing = 1;  // frame numbers from one frame to the next (frame_spacing.h); 0: frames are independent
  int sweeps = 3;   // passes over all frames with their neighbours' latest states
};

// Rigid start of every seen frame from its inner landmarks.
Result<void> start_clip(const ReducedHead& head, const Eigen::VectorXd& identity,
                        const ExpressionPrior& prior, std::vector<FaceFrame>& frames,
                        const Progress& progress = {}, std::stop_token stop = {});

struct IdentityFit {
  Eigen::VectorXd identity;  // (I)
  // Pose of the new head frame in the old one. Dense tracks say how the head moves, not where in it the face
  // is: that, common to all frames, comes from the landmarks.
  Pose registration = Pose::Identity();
};

// Joint fit of the identity (unless held at its start), the chosen frames' states (which are updated) and,
// where poses are given, the one rigid motion of the head frame that all of them share (which all given poses
// then undergo). Frames of the resting face all take part, and weigh together as much as the others. Schur
// complement on the frames.
Result<IdentityFit> fit_identity(const ReducedHead& head, const ExpressionPrior& prior,
                                 const ClipFitOptions& options, const Eigen::VectorXd& start,
                                 std::vector<FaceFrame>& frames, const Progress& progress,
                                 std::stop_token stop);

// Every seen frame's state with the identity fixed.
Result<void> fit_states(const ReducedHead& head, const Eigen::VectorXd& identity,
                        const ExpressionPrior& prior, const ClipFitOptions& options,
                        std::vector<FaceFrame>& frames, const Progress& progress, std::stop_token stop);

}  // namespace likeness
