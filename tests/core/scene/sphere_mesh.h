// A finely triangulated sphere, whose answers are known in closed form.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/linalg.h"

namespace likeness {

struct SphereMesh {
  std::vector<Vec3f> vertices;
  std::vector<Triangle> triangles;
};

// Vertices on the sphere, so the surface lies within radius * (pi/rings)^2 / 2 inside it. Outward
// counter-clockwise.
inline SphereMesh sphere_mesh(float radius, const Vec3f& centre, int rings = 200) {
  SphereMesh mesh;
  const int spokes = 2 * rings;
  mesh.vertices.push_back(centre + Vec3f(0, radius, 0));
  for (int ring = 1; ring < rings; ++ring)
    for (int spoke = 0; spoke < spokes; ++spoke) {
      const float polar = std::numbers::pi_v<float> * ring / rings;
      const float around = 2 * std::numbers::pi_v<float> * spoke / spokes;
      mesh.vertices.push_back(centre + radius * Vec3f(std::sin(polar) * std::sin(around), std::cos(polar),
                                                      std::sin(polar) * std::cos(around)));
    }
  mesh.vertices.push_back(centre - Vec3f(0, radius, 0));
  const int south = int(mesh.vertices.size()) - 1;
  const auto at = [spokes](int ring, int spoke) { return 1 + (ring - 1) * spokes + spoke % spokes; };
  for (int spoke = 0; spoke < spokes; ++spoke) {
    mesh.triangles.emplace_back(0, at(1, spoke), at(1, spoke + 1));
    mesh.triangles.emplace_back(south, at(rings - 1, spoke + 1), at(rings - 1, spoke));
    for (int ring = 1; ring + 1 < rings; ++ring) {
      mesh.triangles.emplace_back(at(ring, spoke), at(ring + 1, spoke), at(ring, spoke + 1));
      mesh.triangles.emplace_back(at(ring, spoke + 1), at(ring + 1, spoke), at(ring + 1, spoke + 1));
    }
  }
  return mesh;
}

}  // namespace likeness
