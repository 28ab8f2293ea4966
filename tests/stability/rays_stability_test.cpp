// Claims about rays that miss, graze, run along borders or start inside, through empty, solid and random
// grids.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/render/rays.h"

namespace likeness {
namespace {

OccupancyGrid grid_of(int kind, std::uint32_t seed) {
  OccupancyGrid grid = make_occupancy(24, kind == 1);
  std::mt19937 random(seed);
  if (kind == 2)
    for (int i = 0; i < 24 * 24 * 24; ++i)
      if (random() % 5 == 0) set_occupied(grid, i % 24, i / 24 % 24, i / 576, true);
  return grid;
}

std::vector<FieldRay> hard_rays() {
  std::vector<FieldRay> rays;
  const float third = 1.f / 3, cell = 1.f / 24;
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {1.f, -1.f})
      for (const float u : {-0.1f, 0.f, cell, 0.5f, third, 1 - cell, 1.f, std::nextafter(1.f, 2.f), 1.1f})
        for (const float v : {0.f, cell, 0.37f, 1.f}) {
          Vec3f origin = Vec3f::Constant(u), direction = Vec3f::Zero();
          origin[(axis + 1) % 3] = v;
          direction[axis] = sign;
          origin[axis] = -2 * sign + 0.5f;
          rays.push_back({origin, direction});
          rays.push_back({origin + 2 * direction, direction});  // starts inside or beside
          direction[(axis + 1) % 3] = 1e-20f;
          rays.push_back({origin, direction});
        }
  for (const float far : {3.f, 1e3f, 1e6f})  // along diagonals, through corners
    for (const Vec3f& d : {Vec3f(1, 1, 1), Vec3f(1, -1, 0), Vec3f(0, 1, 1)})
      rays.push_back({Vec3f::Constant(0.5f) - far * d.normalized(), d.normalized()});
  return rays;
}

TEST(RaysStability, SamplesLieInTheCubeAndStandForNoMoreThanTheChord) {
  for (int kind = 0; kind < 3; ++kind) {
    const OccupancyGrid grid = grid_of(kind, 1), none;
    std::vector<std::uint8_t> opacity(24 * 24 * 24);
    for (std::size_t i = 0; i < opacity.size(); ++i) opacity[i] = std::uint8_t(37 * i % 256);
    for (const bool known : {false, true}) {
      MarchVolumes volumes;
      volumes.fields[0] = march_volume(grid, none, 0.3f);
      if (known) volumes.fields[0].opacity = opacity;
      volumes.near = 0, volumes.far = 1e7f;
      for (const FieldRay& ray : hard_rays())
        for (const std::uint64_t jitter : {0, 11}) {
          RayRequest request;
          request.fields[0] = ray, request.jitter = jitter;
          SampleBatch batch;
          sample_rays(std::span(&request, 1), volumes, batch);
          float length = 0;
          for (const float dt : batch.dt) {
            ASSERT_TRUE(std::isfinite(dt) && dt >= 0) << dt;
            length += dt * 0.3f;
          }
          // Far away, floats are coarse.
          EXPECT_LE(length, std::sqrt(3.f) * (1 + 1e-4f) + 1e-6f * ray.origin.norm());
          const FieldSamples& s = batch.fields[0];
          for (std::size_t i = 0; i < s.count(); ++i)
            for (const float x : {s.x[i], s.y[i], s.z[i]}) ASSERT_TRUE(x >= 0 && x <= 1) << x;
          if (kind == 0) {
            EXPECT_EQ(s.count(), 0u);
          }
        }
    }
  }
}

TEST(RaysStability, ARayFromInsideASolidCubeSeesUpToItsWall) {
  const OccupancyGrid all = grid_of(1, 0), none;
  std::vector<Interval> found;
  occupied_intervals({{0.5f, 0.5f, 0.5f}, {0, 0, 1}}, march_volume(all, none), 0, 10, found);
  float length = 0;
  for (const Interval& i : found) length += i.far - i.near;
  EXPECT_NEAR(length, 0.5f, 1e-6);
}

TEST(RaysStability, ARayThatIsNotANumberHasNoSample) {
  const OccupancyGrid all = grid_of(1, 0), none;
  MarchVolumes volumes;
  volumes.fields[0] = march_volume(all, none);
  const float nan = std::nanf("");
  for (const FieldRay& ray :
       {FieldRay{{nan, 0.5f, -1}, {0, 0, 1}}, FieldRay{{0.5f, 0.5f, -1}, {nan, nan, nan}}}) {
    RayRequest request;
    request.fields[0] = ray;
    SampleBatch batch;
    sample_rays(std::span(&request, 1), volumes, batch);
    for (const float dt : batch.dt) EXPECT_TRUE(std::isfinite(dt));
  }
}

}  // namespace
}  // namespace likeness
