// A tiny avatar with all that a sample can pass on its way to a field: a grid with opacities and a core, a
// warped face with an open mouth, a bent neck, a torso that deforms.
#pragma once

#include <cmath>
#include <random>

#include "core/base/rigid.h"
#include "core/field/field_layout.h"
#include "core/render/render.h"
#include "tests/core/render/tiny_avatar.h"

namespace likeness {

inline Avatar posable_avatar() {
  Avatar a = tiny_avatar();
  const int n = 24;
  std::mt19937 random(11);
  a.head.occupancy = make_occupancy(n, false);
  a.head.core = make_occupancy(n, false);
  a.head.opacity.assign(std::size_t(n) * n * n, 0);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const float r = Vec3f(float(x) - 11.5f, 0.7f * (float(y) - 11.5f), float(z) - 11.5f).norm();
        if (r > 8) continue;
        set_occupied(a.head.occupancy, x, y, z, true);
        if (r < 2.5f) set_occupied(a.head.core, x, y, z, true);
        a.head.opacity[(std::size_t(z) * n + std::size_t(y)) * n + std::size_t(x)] =
            std::uint8_t(random() % 120);
      }
  // A trained field differs from place to place, a new one hardly.
  for (Field* field : {&a.head.field, &a.torso->field})
    for (std::size_t i = 0; i < make_layout(field->config).table_count; ++i)
      field->parameters[i] = float(int(random() % 2001) - 1000) / 250;
  a.warp_cell = 0.02f;
  a.neck = {-0.09f, -0.02f, Vec3f(0, -0.05f, 0)};
  a.intrinsics = {70, 50, 90, 90, 34, 26, 0.01, 0, 0, 0};
  a.plate = Image8(70, 50, 3, 77);
  return a;
}

// A lattice over the head's cube, its ways smooth, and in its middle an open mouth.
inline WarpLattice made_up_lattice(float phase) {
  WarpLattice lattice;
  lattice.origin = Vec3f::Constant(-0.09f), lattice.cell = 0.02f, lattice.nodes = {10, 10, 10};
  lattice.unit = 1e-6f;
  std::int32_t rows = 2;
  for (int c = 0; c < 100; ++c) {
    const auto first = std::int16_t(c % 3), stored = std::int16_t(c % 7 == 0 ? 0 : 9 - c % 3);
    lattice.columns.push_back({rows - first, first, stored});
    if (stored > 0) rows += stored + 1;
  }
  lattice.displacement.assign(3 * std::size_t(rows), 0);
  for (int c = 0; c < 100; ++c)
    for (int z = lattice.columns[std::size_t(c)].first, k = 0; k < lattice.columns[std::size_t(c)].stored;
         ++z, ++k)
      for (int a = 0; a < 3; ++a)
        lattice.displacement[std::size_t(3 * (lattice.columns[std::size_t(c)].base + z) + a)] =
            std::int16_t(4000 * std::sin(phase + 0.3f * float(c % 10 + 2 * a) + 0.2f * float(c / 10 + z)));
  MouthGap& gap = lattice.mouth;
  gap.open = 0.01f;
  gap.low = {-0.04f, -0.05f, -0.05f}, gap.high = {0.04f, 0.02f, 0.08f};
  gap.edges.right = -0.03f, gap.edges.left = 0.03f;
  for (std::size_t i = 0; i < kLipColumns; ++i) {
    const float bow = std::sin(3.14f * float(i) / (kLipColumns - 1));
    gap.edges.upper_y[i] = 0.012f * bow, gap.edges.lower_y[i] = -0.02f * bow;
    gap.edges.upper_z[i] = gap.edges.lower_z[i] = 0.05f + 0.01f * bow;
    gap.margin[i] = 0.001f;
  }
  gap.jaw = {0, 0.01f, -0.03f};
  gap.lower_normal = Vec3f(0, 0.95f, 0.3f).normalized();
  gap.upper_height = -0.01f, gap.lower_height = -0.02f;
  gap.turn = Eigen::AngleAxisf(0.1f, Vec3f::UnitX()).toRotationMatrix();
  gap.shift = {0, 0.001f, 0}, gap.pocket = {0, 0.03f, -0.04f};
  return lattice;
}

// number: 0, 1, ...: another pose, and tables of other sizes.
inline RenderState posed_state(const Avatar& avatar, int number) {
  RenderState state = typical_state(avatar);
  const double turn = 0.25 + 0.1 * number;
  state.pose.world_from_head.rotate(rotation_about(Vec3d(0.3, 1, 0.2).normalized(), turn));
  state.warp = made_up_lattice(float(number));
  state.pose.articulation.expression *= float(number + 1);
  TorsoField& torso = state.torso;
  torso.grid = {Vec2f(-0.1f, -0.3f), 0.05f, 4 + number, 5};
  for (int i = 0; i < 2 * torso.grid.nodes(); ++i)
    torso.displacement.push_back(0.01f * std::sin(float(i + number)));
  torso.hem = TorsoHem{-0.12f, 0.05f, -0.1f};
  return state;
}

}  // namespace likeness
