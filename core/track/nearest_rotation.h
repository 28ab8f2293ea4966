// The rotation nearest to a matrix, in the Frobenius norm (Kabsch 1976). Of a sum of rotations: their chordal
// mean.
#pragma once

#include "core/base/linalg.h"

namespace likeness {

Mat3d nearest_rotation(const Mat3d& m);

}  // namespace likeness
