// How a torso deforms: shoulders, collar and chest do not move as one rigid piece. A few displacement modes,
// learnt from the training frames, lie on a grid in the torso frame's x-y plane and continue unchanged along
// z and beyond the grid's border.
//
// A frame's torso is nine numbers: three of its pose (turn about the torso's z axis, shift along x and y) and
// kTorsoModes coefficients. To look a world point up in the torso's field:
//   p = world_from_torso^-1 * world;  canonical = p + torso_displacement(field, p)
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/base/linalg.h"

namespace likeness {

// With three, the shoulders of a speaker leaning further than in training lagged by a pixel of 256.
inline constexpr int kTorsoModes = 6;

// Coefficients of one frame, in standard deviations over the training frames.
using TorsoShape = std::array<float, kTorsoModes>;

// Where the nodes are.
struct TorsoGrid {
  Vec2f origin = Vec2f::Zero();  // of node (0, 0), torso frame, m
  float cell = 0;                // m between nodes
  int columns = 0, rows = 0;     // along x and y, both at least 2; 0: the torso is rigid

  int nodes() const { return columns * rows; }
  bool empty() const { return columns == 0; }
};

// The four nodes around a place and their weights; places outside count as the nearest on the border.
struct GridPlace {
  std::array<int, 4> node{};
  std::array<float, 4> weight{};
};
GridPlace place_in(const TorsoGrid& grid, float x, float y);

// Where the pictures end below: nothing was learnt of what lies deeper, and the torso goes on there as it is
// at the hem, as far as its occupied cells reach. Canonical torso frame: y = height + slope_x x + slope_z z,
// m; a plane through a camera, so that what is nearer to it ends higher.
struct TorsoHem {
  float height = 0, slope_x = 0, slope_z = 0;
  float at(float x, float z) const { return height + slope_x * x + slope_z * z; }
};

// What all frames share. Displacement of the canonical torso's points, posed minus canonical, m:
// mean + sum over k of shape[k] * modes[k], each (rows, columns, 2).
struct TorsoModes {
  TorsoGrid grid;
  std::vector<float> mean;
  std::array<std::vector<float>, kTorsoModes> modes;
  std::optional<TorsoHem> hem{};  // of a trained avatar

  bool empty() const { return grid.empty(); }
};

// Takes modes from a file; an earlier version holds fewer, and the rest stay zero. False, and nullopt, for
// more than kTorsoModes. `modes.mean` is set.
bool take_modes(std::vector<std::vector<float>> from_file, TorsoModes& modes);
std::optional<TorsoShape> take_shape(std::span<const float> from_file);

// False if a file's numbers cannot be modes: sizes that disagree, values that are not finite.
bool is_consistent(const TorsoModes& modes);

// Posed minus canonical at the nodes, (rows, columns, 2), m.
std::vector<float> posed_displacement(const TorsoModes& modes, const TorsoShape& shape);

// One frame's inverse: canonical minus posed, at nodes of the posed torso.
struct TorsoField {
  TorsoGrid grid;
  std::vector<float> displacement;  // (rows, columns, 2), m
  std::optional<TorsoHem> hem{};

  bool empty() const { return grid.empty() && !hem; }
};

// Inverts the displacement. Microseconds; no modes and no hem give an empty field, which moves nothing.
TorsoField torso_field(const TorsoModes& modes, const TorsoShape& shape);

// Canonical minus posed at a point of the torso frame, m. Bilinear, then up to the hem; z is always 0.
Vec3f torso_displacement(const TorsoField& field, const Vec3f& point);

}  // namespace likeness
