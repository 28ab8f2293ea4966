// The look of a face, by which a person is recognised and a covered face detected: the picture aligned by
// eyes and mouth, normalised for brightness and contrast.
#pragma once

#include <array>
#include <vector>

#include "core/base/linalg.h"
#include "core/head/head_model.h"
#include "core/image/image.h"

namespace likeness {

struct FaceLook {
  std::vector<float> values;  // (24, 24) zero mean, unit norm; empty = unknown
};

// picture: one or three channels; points: its pixels. Unknown if the points are not an upright face.
FaceLook face_look(const Image8& picture, const std::array<Vec2d, kLandmarkCount>& points);

// Correlation, -1..1; 0 if either is unknown.
double alike(const FaceLook& a, const FaceLook& b);

// How well each face agrees with the clip's other frames: the mean correlation with the quarter of the
// reference frames that agree best, frames near in time left out; 1 if there is nothing to compare with.
// references: indices into `looks`.
std::vector<double> agreement_of_looks(const std::vector<FaceLook>& looks,
                                       const std::vector<int>& references);

}  // namespace likeness
