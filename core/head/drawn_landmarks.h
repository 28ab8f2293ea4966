// The 68 landmarks where a shape predictor draws them. A head model's own list follows its author's reading
// of iBUG's drawing; a predictor trained on iBUG 300-W puts some of them elsewhere, consistently for
// everybody. A fit that equates the two distorts shape, expression and pose.
#pragma once

#include <array>
#include <span>

#include "core/head/head_model.h"

namespace likeness {

// From the model's landmark to the predictor's on a face seen from the front, in distances between the outer
// corners of the eyes (landmarks 36 and 45): x to the subject's left, y up.
struct LandmarkShift {
  float x = 0, y = 0;
};

// One landmark of a pair, or one in the middle: both halves of the face are treated alike.
struct DrawnLandmark {
  int landmark = 0;
  LandmarkShift shift;
};

// Moves landmarks along the surface they lie on (over neighbouring triangles, so that a lip's landmark stays
// on its lip), and the other side's by the mirrored shift.
void draw_landmarks(HeadModel& model, std::span<const DrawnLandmark> shifts);

// Measured for dlib's predictor against ICT-FaceKit's list and the built-in head's: see drawn_landmarks.cpp.
std::span<const DrawnLandmark> ict_shifts();
std::span<const DrawnLandmark> builtin_shifts();

// Landmark of the other side of the face; its own number for those in the middle.
int mirrored_landmark(int landmark);

}  // namespace likeness
