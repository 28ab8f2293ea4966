// A held-out frame's picture beside the truth, scored.
#pragma once

#include <limits>
#include <span>

#include "core/face/landmarks.h"
#include "core/image/image.h"
#include "core/lab/score/held_out.h"

namespace likeness {

// Mean distances of landmarks found by dlib in a picture and in the truth, px; NaN where there is no face.
struct LandmarkErrors {
  double inner = std::numeric_limits<double>::quiet_NaN();  // all but the jaw's line
  double mouth = inner, eyes = inner;
};

struct FrameScore {
  int frame = 0;
  double mse = 0, person_mse = 0, head_mse = 0, face_mse = 0;  // NaN where a region is empty
  LandmarkErrors landmarks_px;
};

// Region by region; the landmarks are left out. Pictures of one size, in [0, 1].
FrameScore score_picture(const Image& truth, const Image& rendered, const Regions& regions, int frame);

// Both pictures with the truth's box.
LandmarkErrors landmark_errors(const FaceDetector& detector, const Image8& truth, const Image8& rendered);

// Mean over the finite values of f(frame); NaN where there is none.
double mean_finite(std::span<const FrameScore> frames, double (*value)(const FrameScore&));

}  // namespace likeness
