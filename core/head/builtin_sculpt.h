// The shape of the built-in head as a signed distance: smoothly united ellipsoids and capsules, one per
// anatomical mass (cranium, brow ridge, cheekbone, jaw, nose, ...). Everything here is in millimetres, in the
// head's axes (x subject's left, y up, z out of the face), and symmetric in x. Internal to core/head.
#pragma once

#include <algorithm>

#include "core/base/linalg.h"

namespace likeness::builtin {

inline constexpr double kEyeballRadius = 12.1;            // mm
inline const Vec3d kEyeCentre = Vec3d(31.4, 35.3, 82.6);  // of the subject's left eye
inline constexpr double kLidThickness = 1.5;              // mm, eyeball surface to outer lid

inline double smoothstep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
inline double mix(double a, double b, double t) { return a + (b - a) * t; }

// Approximate signed distance to the skin (no ears, no mouth cavity), < 0 inside.
double sculpt_distance(const Vec3d& point);

// The outermost skin point on the ray origin + t * direction, t in (0, reach]; direction is a unit vector and
// the origin lies inside.
Vec3d outermost_hit(const Vec3d& origin, const Vec3d& direction, double reach);

// The skin point seen from the front at (x, y).
Vec3d frontal_hit(double x, double y);

}  // namespace likeness::builtin
