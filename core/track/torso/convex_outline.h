// The convex outline of points in a picture, and whether a place lies in it.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/base/linalg.h"

namespace likeness {

struct ConvexOutline {
  std::vector<Vec2d> corners;  // px; fewer than 3: nothing is inside
  // Unit normals outwards and their offsets: inside where normal . place <= offset for each.
  std::vector<Vec2d> normals;
  std::vector<double> offsets;
  Eigen::AlignedBox2d box;
};

ConvexOutline convex_outline(std::vector<Vec2d> points);

// Whether the outline, with every side moved outwards by the margin (px), contains the place.
bool holds(const ConvexOutline& outline, const Vec2d& place, double margin);

}  // namespace likeness
