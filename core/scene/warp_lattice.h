// The 3DMM deformation field: the place of a point near the posed face when the face is at rest (RigNeRF's
// canonical map; Li 2022, section on the deformation field). Tabulated on a lattice per frame, since it is
// needed at every sample of a ray.
//
// At a posed vertex the field is that vertex's displacement to rest; between vertices a mean weighted by 1 /
// (d^2 + s^2)^2, s = 3 mm; off the surface it continues and fades out, reaching zero at about 35 mm.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/head/expression_detail.h"
#include "core/head/pose_head.h"
#include "core/scene/mouth_pocket.h"

namespace likeness {

// What all frames of a person share.
struct WarpFrame {
  Vec3f origin = Vec3f::Zero();  // of node (0, 0, 0), head frame, m
  float cell = 0.0055f;          // m between nodes
  std::array<int, 3> nodes{};    // along x, y, z; all 0: nothing moves
  std::vector<int> vertices;     // (K) of the model, those that an expression or the jaw moves
  std::vector<Vec3f> rest;       // (K) their places in the canonical face, m
  MouthFrame mouth;
};

// rest: the articulation of the canonical face. cell: halving it costs eight times the memory per frame.
// detail: of the surface from which lattices are made, or null; the canonical face has its own at rest.
// The person comes from a file, so that a lattice may turn out impossible: an Error where it would have more
// than kMostWarpNodes, a head's at the usual cell being some 200,000.
inline constexpr float kWarpCell = 0.0055f;  // m
inline constexpr int kMostWarpNodes = 1 << 23, kMostWarpNodesAlong = 4096;
Result<WarpFrame> make_warp_frame(const HeadModel& model, const HeadShape& shape, const Articulation& rest,
                                  float cell = kWarpCell, const ExpressionDetail* detail = nullptr);

// One frame's field. Of each column of nodes along z only the stretch from the first to the last that moves
// is kept, a quarter of all: training holds as many lattices as pictures.
struct WarpLattice {
  struct Column {
    std::int32_t base = 0;               // of node z the displacement is row base + z
    std::int16_t first = 0, stored = 0;  // z of the first kept node, and how many are kept
  };

  Vec3f origin = Vec3f::Zero();  // head frame, m
  float cell = 0;                // m
  std::array<int, 3> nodes{};
  float unit = 0;               // m a count
  std::vector<Column> columns;  // (y, x)
  // (rows, 3) canonical minus posed, in units. A row of zeros lies before and after every column's, so that
  // the cells at its ends need no special case; the first two rows are zeros, for cells beyond.
  std::vector<std::int16_t> displacement;
  MouthGap mouth;

  bool empty() const { return columns.empty(); }
  std::size_t bytes() const {
    return columns.size() * sizeof(Column) + displacement.size() * sizeof(displacement[0]);
  }
};

// posed: (V) of the model in the head frame.
WarpLattice make_warp_lattice(const WarpFrame& frame, std::span<const Vec3f> posed);

// Displacement to canonical at a point of the head frame, m; zero outside the lattice. Trilinear.
Vec3f displacement_at(const WarpLattice& lattice, const Vec3f& point);

// Moves points of a cube at `origin` with edges of `side` (head frame, m), given in units of it, to canonical
// by displacement_at, and clamps them to the cube. In one thread. x, y, z: (count).
void displace_points(const WarpLattice& lattice, const Vec3f& origin, float side, std::size_t count, float* x,
                     float* y, float* z);

}  // namespace likeness
