// The chordal mean of rotations, and how far they turn about it.
#pragma once

#include <span>

#include "core/base/linalg.h"

namespace likeness {

// The rotation nearest to a matrix, in the Frobenius norm (Kabsch 1976).
Mat3d nearest_rotation(const Mat3d& m);

// The rotation whose summed squared distance to all of them, in the Frobenius norm, is least; the identity if
// there are none.
Mat3d mean_rotation(std::span<const Mat3d> rotations);

// Rms angle between the rotations and their mean, rad; 0 if there are none.
double turn_about_mean(std::span<const Mat3d> rotations);

}  // namespace likeness
