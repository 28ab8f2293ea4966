// The condition of an articulation, and occupancy bits.
#include "core/render/avatar.h"

#include <algorithm>

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

Eigen::VectorXf condition(const ConditionMap& map, const Articulation& articulation,
                          std::span<const AttributeRegion> attributes, std::span<const float> amounts) {
  LIKENESS_CHECK(amounts.empty() || amounts.size() == attributes.size(), "%zu amounts of %zu attributes",
                 amounts.size(), attributes.size());
  const Eigen::VectorXf face = condition(map, articulation);
  Eigen::VectorXf psi = Eigen::VectorXf::Zero(face.size() + Eigen::Index(attributes.size()));
  psi.head(face.size()) = face;
  for (std::size_t a = 0; a < amounts.size(); ++a)
    psi[face.size() + Eigen::Index(a)] =
        std::clamp(amounts[a], std::min(0.f, attributes[a].low), std::max(0.f, attributes[a].high));
  return psi;
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
