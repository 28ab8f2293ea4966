// The warp lattice in plain loops, one vertex and one node after another: what make_warp_lattice must equal;
// and the look-up in a lattice that keeps every node.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/scene/warp_lattice.h"

namespace likeness {

// (z, y, x) canonical minus posed, m. posed: (V), as make_warp_lattice takes it.
inline std::vector<Vec3f> warp_lattice_reference(const WarpFrame& frame, std::span<const Vec3f> posed) {
  constexpr float kSoftness = 0.003f, kReach = 0.012f, kFadeEnd = 0.035f;  // m, as in warp_lattice.cpp
  const int nx = frame.nodes[0], ny = frame.nodes[1], nz = frame.nodes[2];
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

// A lattice with all its nodes in one block, the still ones, too.
struct DenseLattice {
  Vec3f origin = Vec3f::Zero();  // head frame, m
  float cell = 0, unit = 0;      // m
  std::array<int, 3> nodes{};
  std::vector<std::int16_t> displacement;  // (z, y, x, 3) in units
  MouthGap mouth;
};

inline DenseLattice dense_lattice(const WarpLattice& lattice) {
  const auto [nx, ny, nz] = lattice.nodes;
  DenseLattice dense{lattice.origin, lattice.cell, lattice.unit, lattice.nodes, {}, lattice.mouth};
  const std::size_t plane = 3 * std::size_t(nx) * std::size_t(ny);
  dense.displacement.assign(plane * std::size_t(nz), 0);
  for (std::size_t c = 0; c < lattice.columns.size(); ++c) {
    const WarpLattice::Column& column = lattice.columns[c];
    for (int z = column.first; z < column.first + column.stored; ++z)
      std::copy_n(&lattice.displacement[3 * std::size_t(column.base + z)], 3,
                  &dense.displacement[std::size_t(z) * plane + 3 * c]);
  }
  return dense;
}

inline Vec3f displacement_at(const DenseLattice& lattice, const Vec3f& point) {
  if (in_gap(lattice.mouth, point)) return way_to_pocket(lattice.mouth, point);
  const Vec3f p = (point - lattice.origin) / lattice.cell;
  const int x = int(std::floor(p.x())), y = int(std::floor(p.y())), z = int(std::floor(p.z()));
  const auto [nx, ny, nz] = lattice.nodes;
  if (x < 0 || y < 0 || z < 0 || x + 1 >= nx || y + 1 >= ny || z + 1 >= nz) return Vec3f::Zero();
  const float u = p.x() - float(x), v = p.y() - float(y), w = p.z() - float(z);
  const std::int16_t* d = lattice.displacement.data() + 3 * ((std::size_t(z) * ny + y) * nx + x);
  const std::size_t up = 3 * std::size_t(nx), back = up * std::size_t(ny);
  Vec3f sum = Vec3f::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const float weight = (corner & 1 ? u : 1 - u) * (corner & 2 ? v : 1 - v) * (corner & 4 ? w : 1 - w);
    const std::int16_t* at = d + (corner & 1 ? 3 : 0) + (corner & 2 ? up : 0) + (corner & 4 ? back : 0);
    sum += weight * Vec3f(at[0], at[1], at[2]);
  }
  return sum * lattice.unit;
}

}  // namespace likeness
