// A point of the head from frames whose poses are known, and how well those poses foresee it.
#pragma once

#include <vector>

#include "core/base/linalg.h"
#include "core/camera/camera.h"

namespace likeness {

struct PointView {
  Pose cam_from_head;
  Vec2d ray;            // x/z, y/z
  double focal_px = 0;  // rays times this are working px
};

// Gauss-Newton with Cauchy weights, pulled a little to the start: a few frames do not determine depth. Head
// frame, m.
Vec3d solve_point(const std::vector<PointView>& views, const Vec3d& start);

inline constexpr std::size_t kFewestPointViews = 7;

// The point is solved from every second view; how far the others then see it from there, px. Empty where the
// views are fewer than kFewestPointViews or the point does not move with the head by those it was solved
// from.
std::vector<double> foreseen_errors(const std::vector<PointView>& views, const Vec3d& start);

}  // namespace likeness
