// Looking up an attribute's weight.
#include "core/render/attribute.h"

#include <algorithm>
#include <cmath>

namespace likeness {

float region_weight(const AttributeRegion& region, const Vec3f& canonical) {
  const Vec3f at = (canonical - region.origin) / region.cell;
  int low[3];
  float part[3];
  for (int a = 0; a < 3; ++a) {
    const float floored = std::floor(at[a]);
    if (!(floored >= 0) || !(floored + 1 < float(region.count[std::size_t(a)]))) return 0;
    low[a] = int(floored), part[a] = at[a] - floored;
  }
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    float share = 1;
    int node[3];
    for (int a = 0; a < 3; ++a) {
      const int upper = corner >> a & 1;
      node[a] = low[a] + upper;
      share *= upper ? part[a] : 1 - part[a];
    }
    const std::size_t index = (std::size_t(node[2]) * std::size_t(region.count[1]) + std::size_t(node[1])) *
                                  std::size_t(region.count[0]) +
                              std::size_t(node[0]);
    sum += share * float(region.weights[index]);
  }
  return std::min(1.f, sum / 255);
}

int attribute_index(std::span<const AttributeRegion> attributes, std::string_view name) {
  for (std::size_t i = 0; i < attributes.size(); ++i)
    if (attributes[i].name == name) return int(i);
  return -1;
}

}  // namespace likeness
