// The point of a triangle nearest to a point.
#pragma once

#include "core/base/linalg.h"

namespace likeness {

// Barycentric coordinates, >= 0 with sum 1, of the point of triangle abc nearest to p.
Vec3d nearest_barycentric(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

}  // namespace likeness
