// The ray through a pixel of a lens with distortion, for processor and device. Plain C++17.
#pragma once

#include <cmath>

#include "core/base/host_device.h"

namespace likeness {

// As Intrinsics in camera.h.
struct LensNumbers {
  double fx, fy, cx, cy;  // px
  double k1, k2, p1, p2;
};

// Distorted normalised coordinates minus a target, and the Jacobian by the undistorted ones.
struct LensResidual {
  double x, y, xx, xy, yy;  // the Jacobian is symmetric

  LIKENESS_HOST_DEVICE LensResidual(const LensNumbers& k, double u, double v, double target_x,
                                    double target_y) {
    const double r2 = u * u + v * v, radial = 1 + r2 * (k.k1 + r2 * k.k2);
    const double slope = k.k1 + 2 * k.k2 * r2;  // d(radial) / d(r2)
    xx = radial + 2 * u * u * slope + 2 * k.p1 * v + 6 * k.p2 * u;
    xy = 2 * u * v * slope + 2 * k.p1 * u + 2 * k.p2 * v;
    yy = radial + 2 * v * v * slope + 6 * k.p1 * v + 2 * k.p2 * u;
    x = u * radial + 2 * k.p1 * u * v + k.p2 * (r2 + 2 * u * u) - target_x;
    y = v * radial + k.p1 * (r2 + 2 * v * v) + 2 * k.p2 * u * v - target_y;
  }
  LIKENESS_HOST_DEVICE double squared() const { return x * x + y * y; }
};

// Normalised coordinates (x, y, 1) of the ray through a pixel; inverts the distortion. Newton with halved
// steps: beyond the radius at which a strong barrel distortion folds back there is no exact inverse, and the
// nearest point found is kept.
LIKENESS_HOST_DEVICE inline void undistorted(const LensNumbers& k, double pixel_x, double pixel_y, double& u,
                                             double& v) {
  const double target_x = (pixel_x - k.cx) / k.fx, target_y = (pixel_y - k.cy) / k.fy;
  u = target_x, v = target_y;
  if (k.k1 == 0 && k.k2 == 0 && k.p1 == 0 && k.p2 == 0) return;
  LensResidual residual(k, u, v, target_x, target_y);
  for (int i = 0; i < 20 && residual.squared() > 1e-26; ++i) {
    const double determinant = residual.xx * residual.yy - residual.xy * residual.xy;
    if (std::fabs(determinant) < 1e-9) return;
    double step_x = (residual.yy * residual.x - residual.xy * residual.y) / determinant;
    double step_y = (residual.xx * residual.y - residual.xy * residual.x) / determinant;
    bool better = false;
    for (int halving = 0; halving < 8 && !better; ++halving, step_x *= 0.5, step_y *= 0.5) {
      const LensResidual next(k, u - step_x, v - step_y, target_x, target_y);
      if (!(next.squared() < residual.squared())) continue;
      u -= step_x, v -= step_y;
      residual = next;
      better = true;
    }
    if (!better) return;
  }
}

}  // namespace likeness
