// Landmarks of neighbouring frames as further voters: followed into a frame by Lucas-Kanade there and back,
// they steady its landmarks, carry them through blur and hands, and tell where the landmarks jump but the
// picture does not.
//
// Only training frames vote and only training frames are changed: a held-out frame keeps what its own picture
// says, and leaks nowhere.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/track/clip_frames.h"

namespace likeness {

struct OpticalOptions {
  double forward_backward_px = 0.7;  // working px the way there and back may miss
  double drift_px = 0.5;             // working px a vote's doubt grows with each frame it was followed
  int reach = 3;   // frames that were read (frame_spacing.h) from a frame to a voter, at most
  int carry = 12;  // frames that landmarks are carried through where the face is not found
};

// What the neighbours say about a frame's inner landmarks.
struct OpticalVerdict {
  int votes = 0;               // points followed into it
  double disagreement_px = 0;  // source px, median distance of votes to the frame's own landmarks
  bool carried = false;        // its landmarks now come from its neighbours
};

// One verdict a frame; landmarks and spreads of training frames are updated.
Result<std::vector<OpticalVerdict>> support_landmarks(ClipFrames& clip, const OpticalOptions& options,
                                                      const Progress& progress, std::stop_token stop);

}  // namespace likeness
