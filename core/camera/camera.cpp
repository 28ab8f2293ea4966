// Camera look-up, the inverse of the distortion model, and intrinsics of a crop.
#include "core/camera/camera.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace likeness {
namespace {

// Distorted normalised coordinates and their Jacobian with respect to the undistorted ones.
Vec2d distort(const Intrinsics& k, const Vec2d& p, Eigen::Matrix2d* jacobian) {
  const double x = p.x(), y = p.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k.k1 + r2 * k.k2);
  if (jacobian) {
    const double slope = k.k1 + 2 * k.k2 * r2;  // d(radial) / d(r2)
    (*jacobian)(0, 0) = radial + 2 * x * x * slope + 2 * k.p1 * y + 6 * k.p2 * x;
    (*jacobian)(0, 1) = 2 * x * y * slope + 2 * k.p1 * x + 2 * k.p2 * y;
    (*jacobian)(1, 0) = 2 * x * y * slope + 2 * k.p1 * x + 2 * k.p2 * y;
    (*jacobian)(1, 1) = radial + 2 * y * y * slope + 6 * k.p1 * y + 2 * k.p2 * x;
  }
  return {x * radial + 2 * k.p1 * x * y + k.p2 * (r2 + 2 * x * x),
          y * radial + k.p1 * (r2 + 2 * y * y) + 2 * k.p2 * x * y};
}

}  // namespace

const Camera* find_camera(const CameraSet& set, int frame) {
  if (set.is_static) return set.cameras.empty() ? nullptr : &set.cameras.front();
  const auto it = std::lower_bound(set.cameras.begin(), set.cameras.end(), frame,
                                   [](const Camera& camera, int number) { return camera.frame < number; });
  return it != set.cameras.end() && it->frame == frame ? &*it : nullptr;
}

Vec3d ray_direction(const Intrinsics& k, const Vec2d& pixel) {
  const Vec2d target((pixel.x() - k.cx) / k.fx, (pixel.y() - k.cy) / k.fy);
  if (k.k1 == 0 && k.k2 == 0 && k.p1 == 0 && k.p2 == 0) return {target.x(), target.y(), 1};
  // Newton with halved steps: beyond the radius at which a strong barrel distortion folds back there is no
  // exact inverse, and the nearest point found is kept.
  Vec2d p = target;
  Eigen::Matrix2d jacobian;
  Vec2d residual = distort(k, p, &jacobian) - target;
  for (int i = 0; i < 20 && residual.squaredNorm() > 1e-26; ++i) {
    const double determinant = jacobian.determinant();
    if (std::abs(determinant) < 1e-9) break;
    Vec2d step = jacobian.inverse() * residual;
    bool better = false;
    for (int halving = 0; halving < 8 && !better; ++halving, step *= 0.5) {
      Eigen::Matrix2d next_jacobian;
      const Vec2d next = p - step, next_residual = distort(k, next, &next_jacobian) - target;
      if (next_residual.squaredNorm() < residual.squaredNorm()) {
        p = next;
        residual = next_residual;
        jacobian = next_jacobian;
        better = true;
      }
    }
    if (!better) break;
  }
  return {p.x(), p.y(), 1};
}

Intrinsics crop_intrinsics(const Intrinsics& k, double x, double y, double side, int size) {
  LIKENESS_CHECK(side > 0 && size > 0, "crop of side %g to %d px", side, size);
  const double scale = size / side;
  Intrinsics result = k;
  result.width = result.height = size;
  result.fx = k.fx * scale;
  result.fy = k.fy * scale;
  result.cx = (k.cx - x) * scale;
  result.cy = (k.cy - y) * scale;
  return result;
}

Camera resized(Camera camera, int width) {
  Intrinsics& k = camera.intrinsics;
  const double scale = double(width) / std::max(1, k.width);
  k.fx *= scale, k.fy *= scale, k.cx *= scale, k.cy *= scale;
  k.height = int(std::lround(k.height * scale));
  k.width = width;
  return camera;
}

}  // namespace likeness
