// A box-shaped room with noise on its walls, seen from inside: pictures with known cameras, made by casting
// rays.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/rigid.h"
#include "core/camera/camera.h"
#include "core/image/image.h"

namespace likeness {

inline float lattice_noise(int x, int y, int z) {
  std::uint32_t h =
      std::uint32_t(x) * 73856093u ^ std::uint32_t(y) * 19349663u ^ std::uint32_t(z) * 83492791u;
  h ^= h >> 13, h *= 0x5bd1e995u, h ^= h >> 15;
  return float(h & 0xffff) / 65535.0f;
}

// Smooth noise in [0, 1] of two octaves, one every 8 and one every 2.5 units.
inline float wall_texture(double u, double v, int wall) {
  float sum = 0;
  const double periods[] = {8, 2.5};
  for (int octave = 0; octave < 2; ++octave) {
    const double x = u / periods[octave] + 1000, y = v / periods[octave] + 1000;
    const int ix = int(x), iy = int(y);
    const float fx = float(x - ix), fy = float(y - iy);
    const auto at = [&](int dx, int dy) { return lattice_noise(ix + dx, iy + dy, wall * 7 + octave); };
    sum += 0.5f *
           ((at(0, 0) * (1 - fx) + at(1, 0) * fx) * (1 - fy) + (at(0, 1) * (1 - fx) + at(1, 1) * fx) * fy);
  }
  return sum;
}

// The room is [-2, 2] x [-1.5, 1.5] x [-2, 2]; a pillar [-0.3, 0.3] wide stands off the far wall for depth.
inline Image8 render_room(const Intrinsics& k, const Pose& cam_from_world) {
  Image8 picture(k.width, k.height, 3);
  const Pose world_from_cam = inverse(cam_from_world);
  const Vec3d eye = world_from_cam.translation(), half(2, 1.5, 2);
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const Vec3d ray = world_from_cam.linear() * ray_direction(k, {x + 0.5, y + 0.5});
      double nearest = 1e9;
      int wall = 0;
      for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(ray[axis]) < 1e-9) continue;
        const double distance = ((ray[axis] > 0 ? half[axis] : -half[axis]) - eye[axis]) / ray[axis];
        if (distance < nearest) nearest = distance, wall = 2 * axis + (ray[axis] > 0);
      }
      const double to_pillar = (1.2 - eye.z()) / ray.z();
      const Vec3d on_pillar = eye + to_pillar * ray;
      if (to_pillar > 0 && to_pillar < nearest && std::abs(on_pillar.x() - 0.5) < 0.3)
        nearest = to_pillar, wall = 6;
      const Vec3d hit = eye + nearest * ray;
      const int axis = wall == 6 ? 2 : wall / 2;
      const double u = hit[(axis + 1) % 3] * 60, v = hit[(axis + 2) % 3] * 60;
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] =
            std::uint8_t(std::clamp(255.0f * wall_texture(u, v, wall * 3 + (c == 2)), 0.0f, 255.0f));
    }
  return picture;
}

// A camera at `eye` that looks at `target`, y down.
inline Pose look_at(const Vec3d& eye, const Vec3d& target) {
  const Vec3d z = (target - eye).normalized(), x = Vec3d(0, 1, 0).cross(z).normalized(), y = z.cross(x);
  Pose cam_from_world = Pose::Identity();
  cam_from_world.linear().row(0) = x;
  cam_from_world.linear().row(1) = y;
  cam_from_world.linear().row(2) = z;
  cam_from_world.translation() = -(cam_from_world.linear() * eye);
  return cam_from_world;
}

}  // namespace likeness
