// The 3DMM deformation field: where a point near the posed face lies when the face rests (RigNeRF's
// canonical map; Li 2022, section on the deformation field). Tabulated on a lattice a frame, since the walk
// of a ray asks for it at every sample.
//
// At a posed vertex the field is that vertex's way back to rest; between vertices a mean weighted by
// 1 / (d^2 + s^2)^2, s = 3 mm; off the surface it carries on and fades out, being zero from about 35 mm on.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

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

// rest: the articulation of the canonical face. cell: halving it costs eight times the memory a frame.
WarpFrame make_warp_frame(const HeadModel& model, const HeadShape& shape, const Articulation& rest,
                          float cell = 0.0055f);

// One frame's field.
struct WarpLattice {
  Vec3f origin = Vec3f::Zero();  // head frame, m
  float cell = 0;                // m
  std::array<int, 3> nodes{};
  float unit = 0;                          // m a count
  std::vector<std::int16_t> displacement;  // (z, y, x, 3) canonical minus posed, in units
  MouthGap mouth;

  bool empty() const { return displacement.empty(); }
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
