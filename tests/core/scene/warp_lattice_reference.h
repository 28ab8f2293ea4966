// The warp lattice in plain loops, one vertex and one node after another: what make_warp_lattice must equal.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/scene/warp_lattice.h"

namespace likeness {

// (z, y, x) canonical minus posed, m. posed: (V), as make_warp_lattice takes it.
inline std::vector<Vec3f> warp_lattice_reference(const WarpFrame& frame, std::span<const Vec3f> posed) {
  constexpr float kSoftness = 0.003f, kReach = 0.012f, kFadeEnd = 0.035f;  // m, as in warp_lattice.cpp
  const auto [nx, ny, nz] = frame.nodes;
  const std::size_t count = std::size_t(nx) * std::size_t(ny) * std::size_t(nz);
  std::vector<Vec3f> way(count, Vec3f::Zero());
  std::vector<float> weight(count, 0.f);
  const auto index = [&](int x, int y, int z) {
    return (std::size_t(z) * std::size_t(ny) + std::size_t(y)) * std::size_t(nx) + std::size_t(x);
  };

  // -- Vertices onto the nodes near them
  for (std::size_t k = 0; k < frame.vertices.size(); ++k) {
    const Vec3f& p = posed[std::size_t(frame.vertices[k])];
    const Vec3f c = (p - frame.origin) / frame.cell;
    const int r = int(std::ceil(kReach / frame.cell));
    for (int z = int(c.z()) - r; z <= int(c.z()) + r + 1; ++z)
      for (int y = int(c.y()) - r; y <= int(c.y()) + r + 1; ++y)
        for (int x = int(c.x()) - r; x <= int(c.x()) + r + 1; ++x) {
          if (x < 0 || y < 0 || z < 0 || x >= nx || y >= ny || z >= nz) continue;
          const Vec3f node = frame.origin + frame.cell * Vec3f(float(x), float(y), float(z));
          const float d = (node - p).squaredNorm();
          if (d >= kReach * kReach) continue;
          const float near = 1 / (d + kSoftness * kSoftness), end = 1 - d / (kReach * kReach);
          const float w = near * near * end * end;
          way[index(x, y, z)] += w * (frame.rest[k] - p);
          weight[index(x, y, z)] += w;
        }
  }
  std::vector<bool> known(count);
  for (std::size_t i = 0; i < count; ++i)
    if (weight[i] > 0) way[i] /= weight[i], known[i] = true;

  // -- Layers of neighbours, fading
  const int layers = std::max(1, int(std::round((kFadeEnd - kReach) / frame.cell)));
  for (int layer = 1; layer <= layers; ++layer) {
    const std::vector<bool> before = known;
    const float keep = float(layers + 1 - layer) / float(layers + 2 - layer);
    for (int z = 0; z < nz; ++z)
      for (int y = 0; y < ny; ++y)
        for (int x = 0; x < nx; ++x) {
          if (before[index(x, y, z)]) continue;
          Vec3f sum = Vec3f::Zero();
          int found = 0;
          const auto look = [&](int a, int b, int c) {
            if (a < 0 || b < 0 || c < 0 || a >= nx || b >= ny || c >= nz || !before[index(a, b, c)]) return;
            sum += way[index(a, b, c)], ++found;
          };
          look(x - 1, y, z), look(x + 1, y, z), look(x, y - 1, z), look(x, y + 1, z), look(x, y, z - 1),
              look(x, y, z + 1);
          if (found == 0) continue;
          way[index(x, y, z)] = sum * (keep / float(found));
          known[index(x, y, z)] = true;
        }
  }
  return way;
}

}  // namespace likeness
