// A small avatar for tests: random fields in a few cells, every member filled.
#pragma once

#include "core/base/rigid.h"
#include "core/render/avatar.h"

namespace likeness {

inline Avatar tiny_avatar() {
  Avatar a;
  FieldConfig head;
  head.position = {3, 3, 4, 8, 4, 16};
  head.condition_count = 2;
  head.ambient_grid = {2, 2, 4, 6, 4, 8};
  head.slice_width = 8, head.slice_levels = 2, head.density_width = 16, head.colour_width = 16;
  head.initial_density = 20;
  head.latent_count = 3;
  a.head.field = make_field(head, 5);
  a.head.cube = {Vec3f(-0.1f, -0.1f, -0.1f), 0.2f};
  a.head.occupancy = make_occupancy(8, false);
  for (int z = 2; z < 6; ++z)
    for (int y = 2; y < 6; ++y)
      for (int x = 2; x < 6; ++x) set_occupied(a.head.occupancy, x, y, z, true);
  FieldConfig torso;
  torso.position = {3, 2, 4, 8, 4, 8};
  torso.density_width = 16, torso.colour_width = 16;
  torso.initial_density = 20;
  a.torso.emplace();
  a.torso->field = make_field(torso, 6);
  a.torso->cube = {Vec3f(-0.15f, -0.35f, -0.15f), 0.3f};
  a.torso->occupancy = make_occupancy(8, true);
  a.condition.mean = Eigen::VectorXf::LinSpaced(11, -0.2f, 0.3f);
  a.condition.rows = Eigen::MatrixXf::Random(2, 11);
  a.condition.low = Eigen::VectorXf::Constant(2, -2), a.condition.high = Eigen::VectorXf::Constant(2, 2);
  a.person.identity = Eigen::VectorXf::LinSpaced(4, -1, 1);
  a.person.offsets = {{0.001f, -0.002f, 1e-7f}, {0, 0.5f, -0.25f}};
  a.head_model_name = "test head";
  a.head_model_hash = "0123";
  a.neutral.expression = Eigen::VectorXf::LinSpaced(2, 0, 0.1f);
  a.seen = {{"jawOpen", -0.01f, 0.8f}};
  a.world_from_head.translate(Vec3d(0.01, 0.02, 0.8)).rotate(rotation_about(Vec3d::UnitX(), 3.1));
  a.world_from_torso = a.world_from_head;
  a.intrinsics = {24, 24, 40, 40, 12, 12, 0.01, 0, 0, 0};
  a.plate = Image8(24, 24, 3, 77);
  a.size = 24;
  a.steps = 123, a.seed = 9;
  a.train_seconds = 1.5;
  return a;
}

}  // namespace likeness
