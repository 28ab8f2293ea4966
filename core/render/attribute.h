// An attribute of an avatar: a change of the face that no expression of the head model carries - a puffed
// cheek, a dimple - which the user painted, and which is one entry of the head field's condition. It acts in
// its own region of the canonical face and nowhere else (the idea of CoNeRF, Kania et al. 2022, whose values
// are learnt with the field; here they are regressed before the training, see core/train/attribute_values.h).
//
//   psi(x) = [psi of the expression, amount_0 w_0(x), amount_1 w_1(x), ...]
//
// w is 0 outside the region, so that there the field is the same whatever the amounts are, to the bit.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/linalg.h"

namespace likeness {

struct AttributeRegion {
  std::string name;
  float low = 0, high = 0;  // amounts that the training frames show; 0 is the person's usual state
  float coverage = 0;  // share of the training frames whose amount is more than a fifth of the larger end
  // w at the nodes of a lattice in the head frame, over the canonical face; trilinear between them, 0
  // outside.
  Vec3f origin = Vec3f::Zero();       // m, of the first node
  float cell = 0;                     // m between nodes
  std::array<int, 3> count{};         // nodes along x, y, z
  std::vector<std::uint8_t> weights;  // (z, y, x), 255 = 1; those on the lattice's border are 0
};

inline constexpr int kMaxAttributes = 16;

float region_weight(const AttributeRegion& region, const Vec3f& canonical);  // m, head frame; 0..1

// -1 if there is none of that name.
int attribute_index(std::span<const AttributeRegion> attributes, std::string_view name);

}  // namespace likeness
