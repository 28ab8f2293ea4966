// The head track refined on the pictures themselves: albedo and light of the face from training frames, then
// pose (tight where it is a dense one), jaw and expression of every frame by the photometric error, landmarks
// and the usual priors.
//
// Grey pictures decide; display-referred values are linearised inside (lighting.h). Held-out frames take no
// part in what is shared and are fitted to it on their own picture, without neighbours.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/face/fit_clip.h"
#include "core/head/pose_head.h"
#include "core/image/image.h"
#include "core/track/photo/photometric_frame.h"

namespace likeness {

struct PhotometricOptions {
  int rounds = 2;              // appearance, then all frames; each costs about half of the time
  int appearance_frames = 60;  // training frames from which the appearance is estimated
  double weight = 0.3;         // of a picture residual relative to a landmark's
  double landmark_sigma_factor =
      1.5;  // factor on the landmarks' sigma: pictures now give the same information, more precisely
  double turn_hold = 3000;    // per rad, towards the dense pose, which is accurate to a fraction of a pixel
  double shift_hold = 10000;  // per m
  // Shares of both, towards a pose by landmarks: of a frame among others with dense poses, and of a clip
  // without any, whose heads only the pictures can place more precisely.
  double hold_among_dense = 0.2, hold_without_dense = 0.02;
  double expression_change = 4;  // first difference between training frames, per unit
  double own_hold = 2;           // of a held-out frame's expression towards its landmark fit, per unit
  int spacing = 1;  // frame numbers from one frame to the next (frame_spacing.h); 0: none has a neighbour
  bool read_mouth = true;  // measure the mouth's opening from the pixels
};

struct PhotometricFrame {
  const Image8* grey = nullptr;  // working picture; null: leave the frame alone
  Intrinsics intrinsics;         // of the working picture
  Mat3d world_from_cam = Mat3d::Identity();
};

struct PhotometricSummary {
  int refined = 0, mouths_changed = 0;
  double error_before = 0,
         error_after = 0;  // usual difference from the picture, encoded levels; training frames
};

// Albedo, light and the mouth's inside from the frames `chosen` (indices into faces and pictures), in their
// current states. If stopped, an empty appearance.
Appearance find_appearance(const FaceSurface& surface, const ReducedHead& head,
                           const ReducedPerson& landmark_person,
                           const std::vector<PhotometricFrame>& pictures, const std::vector<FaceFrame>& faces,
                           const std::vector<std::size_t>& chosen, std::stop_token stop);

// pictures: one for each of `faces`, whose states are refined in place. person: the shape that `head` and
// `landmark_person` describe. On an error or a stop the states may be partly refined.
Result<PhotometricSummary> refine_photometric(const HeadModel& model, const HeadShape& person,
                                              const ReducedHead& head, const ReducedPerson& landmark_person,
                                              const ExpressionPrior& prior,
                                              const std::vector<PhotometricFrame>& pictures,
                                              const PhotometricOptions& options,
                                              std::vector<FaceFrame>& faces, const Progress& progress,
                                              std::stop_token stop);

}  // namespace likeness
