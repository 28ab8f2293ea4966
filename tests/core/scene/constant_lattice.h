// A lattice over a cube with a constant displacement, for tests of look-ups through one.
#pragma once

#include "core/scene/warp_lattice.h"

namespace likeness {

// way: canonical minus posed, m, within 0.03.
inline WarpLattice constant_lattice(const Vec3f& origin, float side, const Vec3f& way) {
  constexpr int kNodes = 10;
  WarpLattice lattice;
  lattice.cell = side / float(kNodes - 3);
  lattice.origin = origin - Vec3f::Constant(lattice.cell);
  lattice.nodes = {kNodes, kNodes, kNodes};
  lattice.unit = 1e-6f;
  std::int32_t rows = 2;
  for (int c = 0; c < kNodes * kNodes; ++c) {
    lattice.columns.push_back({rows, 0, kNodes});
    rows += kNodes + 1;
  }
  lattice.displacement.assign(3 * std::size_t(rows), 0);
  for (const WarpLattice::Column& column : lattice.columns)
    for (int z = 0; z < kNodes; ++z)
      for (int a = 0; a < 3; ++a)
        lattice.displacement[std::size_t(3 * (column.base + z) + a)] =
            std::int16_t(std::lround(way[a] / lattice.unit));
  return lattice;
}

}  // namespace likeness
