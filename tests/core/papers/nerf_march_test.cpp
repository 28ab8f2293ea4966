// Claims about the two passes of a ray.
#include "core/papers/nerf_march.h"

#include <gtest/gtest.h>

#include <cmath>

namespace likeness {
namespace {

constexpr float kSurface = 0.55f;  // of the unit cube, along z

// Empty before kSurface along z, soon opaque behind it; or empty everywhere.
NerfField<float> wall(bool there) {
  NerfConfig config;
  config.position_frequencies = config.direction_frequencies = 0;
  config.width = 2, config.layers = 1;
  NerfField<float> field = make_nerf_field(config, 1);
  for (float& v : field.parameters) v = 0;
  // Trunk: W (2, 3) by columns, b (2); density: W (1, 2), b.
  field.parameters[4] = 400;                        // by z, which is centred
  field.parameters[6] = -400 * (2 * kSurface - 1);  // 0 at the surface
  field.parameters[8] = there ? 1 : 0;
  field.parameters[10] = -30;
  return field;
}

struct Cast {
  std::array<NerfPass, 2> passes;
  const NerfPass& coarse() const { return passes[0]; }
  const NerfPass& fine() const { return passes[1]; }
};

Cast cast(bool there, std::uint64_t seed) {
  const NerfPair pair{wall(there), wall(there)};
  const OccupancyGrid everywhere{}, core{};
  NerfScene scene{&pair, nullptr, {}, nullptr, [](SampleBatch&) {}};
  scene.volumes.fields[0] = march_volume(everywhere, core);
  scene.volumes.near = 0;
  std::vector<RayRequest> rays(3);
  for (RayRequest& ray : rays) ray.fields[0] = {Vec3f(0.5f, 0.5f, 0), Vec3f(0, 0, 1)};
  Cast out;
  march_nerf(scene, rays, {.coarse = 32, .fine = 32, .seed = seed}, true, out.passes);
  return out;
}

TEST(NerfMarch, CoarseSamplesAreSpreadEvenly) {
  for (const std::uint64_t seed : {0u, 7u}) {
    const Cast c = cast(true, seed);
    ASSERT_EQ(c.coarse().batch.begin[1], 32u);
    for (int k = 0; k < 32; ++k) {
      EXPECT_NEAR(c.coarse().batch.fields[0].z[std::size_t(k)], (k + 0.5f) / 32, 0.5f / 32 + 1e-5f);
      EXPECT_NEAR(c.coarse().batch.dt[std::size_t(k)], 1.f / 32, 1e-5f);
    }
  }
}

TEST(NerfMarch, FineSamplesGatherWhereTheCoarseFieldLosesTheLight) {
  const Cast c = cast(true, 7);
  int near = 0;
  const std::uint32_t count = c.fine().batch.begin[1];
  ASSERT_EQ(count, 32u);
  float length = 0, last = 0;
  for (std::uint32_t k = 0; k < count; ++k) {
    const float z = c.fine().batch.fields[0].z[k];
    near += std::abs(z - kSurface) < 0.08f;
    length += c.fine().batch.dt[k];
    EXPECT_GE(z, last);
    last = z;
  }
  EXPECT_GE(near, 20);            // evenly spread they would be 5
  EXPECT_NEAR(length, 1, 1e-4f);  // and yet they stand for the whole stretch
  EXPECT_LT(c.fine().rays[0].transmittance, 1e-4f);
  std::vector<float> weights;
  ray_weights(c.fine(), 0, weights);
  double sum = 0;
  for (const float w : weights) sum += w;
  EXPECT_NEAR(sum, 1 - c.fine().rays[0].transmittance, 1e-5);
}

TEST(NerfMarch, FineSamplesStayEvenInEmptySpace) {
  const Cast c = cast(false, 0);
  EXPECT_GT(c.fine().rays[0].transmittance, 0.99f);
  for (int k = 0; k < 32; ++k)
    EXPECT_NEAR(c.fine().batch.fields[0].z[std::size_t(k)], (k + 0.5f) / 32, 1e-3f);
}

TEST(NerfMarch, AnotherSeedMovesEveryRaysSamples) {
  const Cast a = cast(true, 7), b = cast(true, 7), other = cast(true, 8);
  EXPECT_EQ(a.coarse().batch.fields[0].z, b.coarse().batch.fields[0].z);
  EXPECT_NE(a.coarse().batch.fields[0].z, other.coarse().batch.fields[0].z);
  EXPECT_NE(a.coarse().batch.fields[0].z[0], a.coarse().batch.fields[0].z[32]);  // the next ray
}

}  // namespace
}  // namespace likeness
