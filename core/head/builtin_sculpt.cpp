// The masses of the built-in head and the rays that meet them.
#include "core/head/builtin_sculpt.h"

#include <cmath>

namespace likeness::builtin {
namespace {

// -- Distance primitives
// ------------------------------------------------------------------------------------------

double ellipsoid(const Vec3d& p, const Vec3d& centre, const Vec3d& radii) {
  const Vec3d q = (p - centre).cwiseQuotient(radii);
  const double k0 = q.norm(), k1 = q.cwiseQuotient(radii).norm();
  return k1 < 1e-12 ? -radii.minCoeff() : k0 * (k0 - 1) / k1;
}

// A capsule whose radius goes linearly from ra at a to rb at b.
double taper(const Vec3d& p, const Vec3d& a, const Vec3d& b, double ra, double rb) {
  const Vec3d ab = b - a;
  const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (p - a - t * ab).norm() - mix(ra, rb, t);
}

// Union and difference with a fillet of about the width `fillet`.
double unite(double a, double b, double fillet) {
  const double h = std::max(fillet - std::abs(a - b), 0.0) / fillet;
  return std::min(a, b) - h * h * fillet * 0.25;
}
double carve(double a, double b, double fillet) { return -unite(-a, b, fillet); }

// -- Masses
// -------------------------------------------------------------------------------------------------------

double cranium_and_jaw(const Vec3d& p) {
  double d = ellipsoid(p, {0, 62, 4}, {76, 83, 91});                   // braincase
  d = unite(d, ellipsoid(p, {0, 62, 44}, {61, 62, 62}), 24);           // forehead
  d = unite(d, ellipsoid(p, {0, -4, 38}, {60, 80, 63}), 22);           // face
  d = unite(d, taper(p, {10, 50, 96}, {31, 53.5, 93}, 8.5, 8.5), 14);  // brow ridge, inner
  d = unite(d, taper(p, {31, 53.5, 93}, {53, 46, 75}, 8.5, 8), 14);    // brow ridge, outer
  d = unite(d, ellipsoid(p, {46, 11, 68}, {20, 13, 19}), 16);          // cheekbone
  d = unite(d, taper(p, {55, 13, 62}, {64, 16, 20}, 8, 7), 14);        // zygomatic arch
  d = unite(d, taper(p, {57, 6, 14}, {50, -44, 24}, 11, 10), 16);      // ramus
  d = unite(d, taper(p, {50, -44, 24}, {17, -64, 88}, 11, 14), 16);    // jaw body
  d = unite(d, ellipsoid(p, {0, -66, 92}, {20, 16, 18.5}), 16);        // chin
  d = unite(d, ellipsoid(p, {36, -24, 72}, {22, 30, 24}), 18);         // cheek
  d = unite(d, ellipsoid(p, {0, -30, 84}, {33, 28, 28.5}), 14);        // muzzle
  return d;
}

double nose(const Vec3d& p) {
  double d = taper(p, {0, 40, 98}, {0, 10, 114}, 7.6, 9.5);          // bridge
  d = unite(d, ellipsoid(p, {0, 1.5, 117.5}, {10.5, 9.5, 12}), 7);   // tip
  d = unite(d, ellipsoid(p, {11.2, -3.8, 109}, {6.6, 7.4, 10}), 5);  // wing
  d = unite(d, taper(p, {0, -6, 119}, {0, -9, 108}, 4.2, 4.5), 4);   // columella
  d = unite(d, ellipsoid(p, {0, 14, 98}, {16, 24, 14}), 10);         // side walls
  return d;
}

double neck_and_torso(const Vec3d& p) {
  const double lean = (p.y() + 90) * 0.10;  // the neck leans forward going up
  double d = taper(Vec3d(p.x() * 0.96, p.y(), p.z() - lean), {0, -20, -14}, {0, -175, -14}, 50, 54);
  d = unite(d, taper(p, {60, -8, -12}, {12, -160, 26}, 8, 8), 20);        // sternomastoid
  d = unite(d, taper(p, {22, -110, -42}, {120, -196, -32}, 26, 30), 40);  // trapezius
  d = unite(d, taper(p, {0, -235, -22}, {148, -232, -24}, 62, 50), 40);   // shoulders
  d = unite(d, ellipsoid(p, {0, -300, -12}, {170, 150, 96}), 40);         // chest
  return d;
}

}  // namespace

double sculpt_distance(const Vec3d& point) {
  const Vec3d p(std::abs(point.x()), point.y(), point.z());
  double d = cranium_and_jaw(p);
  d = carve(d, ellipsoid(p, {31, 35, 106}, {20, 11.5, 16}), 12);  // socket
  if (p.y() > -60 && p.z() > 60) {
    d = unite(d, nose(p), 9);
    d = carve(d, ellipsoid(p, {6.6, -11, 113.5}, {3.2, 6, 5.2}), 3);  // nostril
    d = unite(d, (p - kEyeCentre).norm() - (kEyeballRadius + kLidThickness), 5);
  }
  if (p.y() < 20) d = unite(d, neck_and_torso(p), 26);
  return d;
}

Vec3d outermost_hit(const Vec3d& origin, const Vec3d& direction, double reach) {
  // March inwards; the distance is approximate where ellipsoids meet, hence the cautious factor.
  double outside = reach, t = reach;
  while (t > 0) {
    const double d = sculpt_distance(origin + t * direction);
    if (d <= 0) break;
    outside = t;
    t -= std::max(0.6 * d, 0.25);
  }
  double inside = std::max(t, 0.0);
  for (int i = 0; i < 22; ++i) {
    const double middle = 0.5 * (inside + outside);
    (sculpt_distance(origin + middle * direction) <= 0 ? inside : outside) = middle;
  }
  return origin + inside * direction;
}

Vec3d frontal_hit(double x, double y) { return outermost_hit({x, y, 0}, {0, 0, 1}, 150); }

}  // namespace likeness::builtin
