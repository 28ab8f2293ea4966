// The condition of an articulation, and occupancy bits.
#include "core/render/avatar.h"

#include "core/base/check.h"

namespace likeness {

Eigen::VectorXf articulation_vector(const Articulation& articulation) {
  const Eigen::Index e = articulation.expression.size();
  Eigen::VectorXf v(e + 9);
  v.head(e) = articulation.expression;
  v.segment<3>(e) = articulation.jaw;
  v.segment<3>(e + 3) = articulation.left_eye;
  v.segment<3>(e + 6) = articulation.right_eye;
  return v;
}

Eigen::VectorXf condition(const ConditionMap& map, const Articulation& articulation) {
  if (map.rows.rows() == 0) return {};
  LIKENESS_CHECK(map.mean.size() == articulation.expression.size() + 9,
                 "condition of %ld entries for %ld expressions", long(map.mean.size()),
                 long(articulation.expression.size()));
  const Eigen::VectorXf psi = map.rows * (articulation_vector(articulation) - map.mean);
  return psi.cwiseMax(map.low).cwiseMin(map.high);
}

OccupancyGrid make_occupancy(int resolution, bool filled) {
  OccupancyGrid grid;
  grid.resolution = resolution;
  const std::size_t cells = std::size_t(resolution) * resolution * resolution;
  grid.bits.assign((cells + 7) / 8, filled ? 0xff : 0);
  return grid;
}

void set_occupied(OccupancyGrid& grid, int x, int y, int z, bool occupied) {
  const std::size_t i = (std::size_t(z) * grid.resolution + y) * grid.resolution + x;
  if (occupied)
    grid.bits[i >> 3] |= std::uint8_t(1u << (i & 7));
  else
    grid.bits[i >> 3] &= std::uint8_t(~(1u << (i & 7)));
}

}  // namespace likeness
