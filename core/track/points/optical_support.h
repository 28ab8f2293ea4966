// Landmarks of neighbouring frames as further voters: tracked into a frame by Lucas-Kanade forward and back,
// they stabilise its landmarks, carry them through blur and hands, and reveal where the landmarks jump but
// the picture does not.
//
// Only training frames vote and only training frames are changed: a held-out frame keeps its own picture's
// landmarks and leaks into no other.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/track/clip_frames.h"

namespace likeness {

struct OpticalOptions {
  double forward_backward_px = 0.7;  // working px allowed between the start and the forward-backward result
  double drift_px = 0.5;             // growth of a vote's uncertainty per frame it was tracked, working px
  int reach = 3;   // frames that were read (frame_spacing.h) from a frame to a voter, at most
  int carry = 12;  // frames through which landmarks are carried if the face is not found
};

// The neighbours' verdict on a frame's inner landmarks.
struct OpticalVerdict {
  int votes = 0;               // points followed into it
  double disagreement_px = 0;  // source px, median distance of votes to the frame's own landmarks
  bool carried = false;        // its landmarks now come from its neighbours
};

// One verdict per frame; landmarks and spreads of training frames are updated.
Result<std::vector<OpticalVerdict>> support_landmarks(ClipFrames& clip, const OpticalOptions& options,
                                                      const Progress& progress, std::stop_token stop);

}  // namespace likeness
