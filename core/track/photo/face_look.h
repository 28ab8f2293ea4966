// How a face looks, by which a person is known again and a covered face gives itself away: the picture
// levelled by eyes and mouth, with brightness and contrast taken out.
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

// picture: one or three channels; points: its pixels. Unknown where the points are no upright face.
FaceLook face_look(const Image8& picture, const std::array<Vec2d, kLandmarkCount>& points);

// Correlation, -1..1; 0 where either is unknown.
double alike(const FaceLook& a, const FaceLook& b);

// How well each face agrees with what the clip shows of it elsewhere: the mean correlation with the quarter
// of the reference frames that agree best, frames near in time left out; 1 where there is nothing to compare
// with. references: indices into `looks`.
std::vector<double> agreement_of_looks(const std::vector<FaceLook>& looks,
                                       const std::vector<int>& references);

}  // namespace likeness
