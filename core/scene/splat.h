// Displacements of vertices spread over the nodes of a lattice near them (core/scene/warp_lattice).
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/base/linalg.h"

namespace likeness {

// A vertex: its place, in cells, and its displacement to rest, m.
struct Pull {
  Vec3f place, way;
};

inline constexpr int kSplatGroup = 8;  // nodes along x summed together

// Sums at the nodes, arrays of (z, y, row). A group of nodes may begin at any node of a row, so rows are
// kSplatGroup - 1 numbers longer than there are nodes.
struct SplatGrid {
  std::array<int, 3> nodes{};  // along x, y, z
  std::size_t row = 0, plane = 0;
  float *x = nullptr, *y = nullptr, *z = nullptr;  // weighted displacements, m
  float* weight = nullptr;
  float reach = 0, softness = 0;  // cells
};

// Adds every pull to the nodes of layers [z0, z1) nearer than the reach r, weighted by
// ((1 - d^2 / r^2) / (d^2 + s^2))^2, s the softness. In one thread.
void splat_pulls(const SplatGrid& grid, std::span<const Pull> pulls, int z0, int z1);

}  // namespace likeness
