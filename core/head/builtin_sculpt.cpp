// The masses of the built-in head and the rays that meet them.
#include "core/head/builtin_sculpt.h"

#include <cmath>

namespace likeness::builtin {
namespace {

// -- Distance primitives

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

// Masses beside the midline meet their mirror image there; a rounded |x| keeps the meeting smooth.
Vec3d beside_midline(const Vec3d& p) { return {std::sqrt(p.x() * p.x() + 9), p.y(), p.z()}; }

// -- Masses

double cranium_and_jaw(const Vec3d& p) {
  const Vec3d q = beside_midline(p);
  double d = ellipsoid(p, {0, 62, 4}, {78, 83, 91});                    // braincase
  d = unite(d, ellipsoid(p, {0, 62, 44}, {61, 62, 62}), 24);            // forehead
  d = unite(d, ellipsoid(q, {35, 40, 45}, {33, 42, 36}), 20);           // temple
  d = unite(d, ellipsoid(p, {0, -4, 38}, {60, 78, 63}), 22);            // face
  d = unite(d, taper(q, {9, 51, 95.5}, {29, 54, 91.5}, 7.5, 7.5), 20);  // brow ridge, inner
  d = unite(d, taper(q, {29, 54, 91.5}, {49, 46, 70}, 7.5, 6.5), 18);   // brow ridge, outer
  d = unite(d, taper(q, {51.5, 44, 71}, {53, 18, 68}, 6, 8), 20);       // outer rim of the orbit
  d = unite(d, ellipsoid(q, {44, 10, 70}, {20, 14, 18}), 20);           // cheekbone
  d = unite(d, taper(q, {54, 12, 60}, {64, 16, 18}, 9, 8), 26);         // zygomatic arch
  d = unite(d, ellipsoid(q, {45.5, -13, 34}, {18.5, 40, 34}), 20);      // masseter and parotid
  d = unite(d, taper(q, {49, -40, 24}, {21, -62, 84}, 10, 10.5), 22);   // jaw body
  d = unite(d, ellipsoid(p, {0, -64.5, 91.5}, {26, 15, 18.5}), 16);     // chin
  d = unite(d, ellipsoid(q, {34, -22, 73}, {22, 32, 24}), 20);          // cheek
  d = unite(d, ellipsoid(p, {0, -31, 88.5}, {27.5, 27, 28.5}), 16);     // muzzle
  return d;
}

double nose(const Vec3d& p) {
  double d = taper(p, {0, 40, 98}, {0, 10, 115.5}, 6.4, 8.2);           // bridge
  d = unite(d, ellipsoid(p, {0, 1.5, 119.3}, {9.6, 9, 12}), 7);         // tip
  d = unite(d, ellipsoid(p, {11.6, -4.4, 108.5}, {6.3, 6.8, 9.4}), 4);  // wing
  d = unite(d, taper(p, {0, -4.5, 120}, {0, -8, 110}, 4.6, 5), 5);      // columella
  d = unite(d, ellipsoid(p, {0, -11.2, 104.5}, {11, 4.5, 9}), 7);       // base
  d = unite(d, ellipsoid(p, {0, 11, 95}, {18.5, 24, 15}), 12);          // side walls
  return d;
}

double neck(const Vec3d& p) {
  const Vec3d q = beside_midline(p);
  const double lean = (p.y() + 90) * 0.10;  // the neck leans forward going up
  double d = taper(Vec3d(p.x() * 0.97, p.y(), p.z() - lean), {0, -20, -14}, {0, -200, -14}, 48, 55);
  d = unite(d, taper(q, {54, -8, -10}, {14, -160, 24}, 7, 7), 24);      // sternomastoid
  d = unite(d, taper(p, {0, -96, 36}, {0, -150, 26}, 8, 8), 24);        // larynx
  d = unite(d, taper(q, {20, -60, -42}, {34, -150, -44}, 18, 26), 30);  // trapezius
  return d;
}

}  // namespace

double sculpt_distance(const Vec3d& point) {
  const Vec3d p(std::abs(point.x()), point.y(), point.z());
  double d = cranium_and_jaw(p);
  d = carve(d, ellipsoid(p, {31, 34.5, 108}, {20, 11.5, 15.5}), 14);  // socket
  if (p.y() > -60 && p.z() > 60) {
    d = unite(d, nose(p), mix(4.5, 10, smoothstep(-9, 12, p.y())));
    d = carve(d, ellipsoid(p, {6.4, -8.6, 114.6}, {3.0, 4.0, 4.6}), 3.5);  // nostril
    d = unite(d, (p - kEyeCentre).norm() - (kEyeballRadius + kLidThickness), 5);
  }
  if (p.y() < 90) d = unite(d, neck(p), 20);
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
