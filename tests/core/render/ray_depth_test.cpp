// Claims about how far away an avatar's surface is: slabs of known density, whose integrals are known.
#include "core/render/ray_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/rigid.h"
#include "core/field/field_layout.h"
#include "tests/core/render/tiny_avatar.h"

namespace likeness {
namespace {

constexpr float kDepthStep = 0.0015f;  // m between samples, as MarchVolumes has it

// The same density everywhere, per side of the field's cube.
void make_uniform(Field& field, float density) {
  std::ranges::fill(field.parameters, 0.f);
  field.parameters[make_layout(field.config).density.back().biases] = std::log(density);
}

// A slab across the whole cube: its cells in z.
void fill_slab(FieldPart& part, int cells, int first, int last) {
  part.occupancy = make_occupancy(cells, false);
  for (int z = first; z <= last; ++z)
    for (int y = 0; y < cells; ++y)
      for (int x = 0; x < cells; ++x) set_occupied(part.occupancy, x, y, z, true);
}

// Of the head's cube, 0.2 m about its middle, all between z = -0.025 and 0.05 m; the camera looks along z
// from 0.8 m away. No torso, unless a test asks for it.
Avatar slab_avatar(float density) {
  Avatar a = tiny_avatar();
  a.torso.reset();
  a.head.opacity.clear();
  make_uniform(a.head.field, density);
  fill_slab(a.head, 8, 3, 5);
  a.world_from_head = Pose::Identity();
  a.world_from_head.translation() = Vec3d(0.01, -0.02, 0.8);
  a.world_from_torso = a.world_from_head;
  a.cam_from_world = Pose::Identity();
  a.intrinsics = {31, 25, 70, 70, 16, 12};
  return a;
}

constexpr double kNear = 0.8 - 0.025, kFar = 0.8 + 0.05;  // m, of the slab from the camera

Vec3d ray_of_pixel(const Avatar& a, std::size_t pixel) {
  const auto width = std::size_t(a.intrinsics.width);
  return ray_direction(a.intrinsics, Vec2d(double(pixel % width) + 0.5, double(pixel / width) + 0.5))
      .normalized();
}

// Whether the ray passes the slab from its front to its back, well within the cube's other sides.
bool passes_slab(const Avatar& a, const Vec3d& ray) {
  for (const double z : {kNear, kFar}) {
    const Vec3d at = ray * (z / ray.z()) - a.world_from_head.translation();
    if (std::abs(at.x()) > 0.098 || std::abs(at.y()) > 0.098) return false;
  }
  return true;
}
bool misses_slab(const Avatar& a, const Vec3d& ray) {
  for (const double z : {kNear, kFar}) {
    const Vec3d at = ray * (z / ray.z()) - a.world_from_head.translation();
    if (std::abs(at.x()) < 0.102 && std::abs(at.y()) < 0.102) return false;
  }
  return true;
}

TEST(RayDepths, OfSomethingOpaqueAreThoseOfItsSurface) {
  const Avatar a = slab_avatar(8000);
  const RayDepths depths = ray_depths(a, typical_camera(a), typical_state(a));
  ASSERT_EQ(depths.metres.size(), 31u * 25u);
  ASSERT_EQ(depths.alpha.size(), depths.metres.size());
  int met = 0, missed = 0;
  for (std::size_t i = 0; i < depths.metres.size(); ++i) {
    const Vec3d ray = ray_of_pixel(a, i);
    if (passes_slab(a, ray)) {
      EXPECT_NEAR(depths.alpha[i], 1, 1e-5) << i;
      EXPECT_GE(depths.metres[i], kNear / ray.z() - 1e-5) << i;
      EXPECT_LE(depths.metres[i], kNear / ray.z() + kDepthStep) << i;
      ++met;
    } else if (misses_slab(a, ray)) {
      EXPECT_EQ(depths.metres[i], 0) << i;
      EXPECT_EQ(depths.alpha[i], 0) << i;
      ++missed;
    }
  }
  EXPECT_GT(met, 100);
  EXPECT_GT(missed, 100);
}

// Light that is taken at a rate of mu falls off as exp(-mu t): over a length L the mean distance of what
// takes it is 1 / mu - L / (exp(mu L) - 1).
TEST(RayDepths, OfMistAreTheMeanOfWhatTakesTheLight) {
  const Avatar a = slab_avatar(5);
  const RayDepths depths = ray_depths(a, typical_camera(a), typical_state(a));
  const double mu = 5 / 0.2;  // per metre
  int met = 0;
  for (std::size_t i = 0; i < depths.metres.size(); ++i) {
    const Vec3d ray = ray_of_pixel(a, i);
    if (!passes_slab(a, ray)) continue;
    const double length = (kFar - kNear) / ray.z(), within = 1 / mu - length / std::expm1(mu * length);
    EXPECT_NEAR(depths.alpha[i], 1 - std::exp(-mu * length), 1e-4) << i;
    EXPECT_NEAR(depths.metres[i], kNear / ray.z() + within, 1e-4) << i;
    ++met;
  }
  EXPECT_GT(met, 100);
}

TEST(RayDepths, FollowTheHeadsPoseAndTheCamera) {
  const Avatar a = slab_avatar(8000);
  Camera camera = typical_camera(a);
  RenderState state = typical_state(a);
  // Head and camera turn together about anywhere: nothing is seen to move.
  Pose turn = Pose::Identity();
  turn.linear() = rotation_about(Vec3d(1, 2, 3).normalized(), 0.7), turn.translation() = Vec3d(0.3, -1, 2);
  const RayDepths still = ray_depths(a, camera, state);
  state.pose.world_from_head = turn * state.pose.world_from_head;
  state.pose.world_from_torso = turn * state.pose.world_from_torso;
  camera.cam_from_world = camera.cam_from_world * inverse(turn);
  const RayDepths turned = ray_depths(a, camera, state);
  for (std::size_t i = 0; i < still.metres.size(); ++i) {
    if (!passes_slab(a, ray_of_pixel(a, i))) continue;
    EXPECT_NEAR(turned.metres[i], still.metres[i], 1e-4) << i;
  }
  // The head alone comes nearer by 0.1 m.
  state = typical_state(a);
  state.pose.world_from_head.translation().z() -= 0.1;
  const RayDepths nearer = ray_depths(a, typical_camera(a), state);
  const std::size_t middle = 12 * 31 + 16;
  EXPECT_NEAR(still.metres[middle] - nearer.metres[middle], 0.1, kDepthStep);
}

// The torso's cube, 0.3 m wide, lies around the head's slab and behind it.
TEST(RayDepths, AreOfTheNearerOfHeadAndTorso) {
  Avatar a = slab_avatar(8000);
  a.torso = tiny_avatar().torso;
  make_uniform(a.torso->field, 12000);
  a.torso->cube = {Vec3f(-0.15f, -0.15f, -0.15f), 0.3f};
  fill_slab(*a.torso, 6, 5, 5);  // z = 0.1 to 0.15 m
  const RayDepths depths = ray_depths(a, typical_camera(a), typical_state(a));
  int head = 0, torso = 0;
  for (std::size_t i = 0; i < depths.metres.size(); ++i) {
    const Vec3d ray = ray_of_pixel(a, i);
    const Vec3d behind = ray * (0.9 / ray.z()) - a.world_from_head.translation();
    if (passes_slab(a, ray)) {
      EXPECT_NEAR(depths.metres[i], kNear / ray.z() + kDepthStep / 2, kDepthStep) << i;
      ++head;
    } else if (misses_slab(a, ray) && std::abs(behind.x()) < 0.14 && std::abs(behind.y()) < 0.14) {
      EXPECT_NEAR(depths.metres[i], 0.9 / ray.z() + kDepthStep / 2, kDepthStep) << i;
      EXPECT_NEAR(depths.alpha[i], 1, 1e-5) << i;
      ++torso;
    }
  }
  EXPECT_GT(head, 100);
  EXPECT_GT(torso, 50);
}

}  // namespace
}  // namespace likeness
