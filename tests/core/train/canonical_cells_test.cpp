// Claims about cells of the canonical face: a march through them matches one through a grid moved by the same
// deformation, and samples are stored where they were taken.
#include "core/train/canonical_cells.h"

#include <gtest/gtest.h>

#include <random>

#include "core/train/cell_math.h"
#include "tests/core/render/tiny_avatar.h"
#include "tests/core/scene/constant_lattice.h"

namespace likeness {
namespace {

constexpr int kCells = 16;
const OccupancyGrid kNoCore;  // outlives the volumes that point to it

OccupancyGrid blob(const std::array<int, 3>& moved) {
  OccupancyGrid grid = make_occupancy(kCells, false);
  for (int z = 0; z < kCells; ++z)
    for (int y = 0; y < kCells; ++y)
      for (int x = 0; x < kCells; ++x)
        if (Vec3f(float(x - moved[0]) - 7.5f, 1.3f * (float(y - moved[1]) - 7.5f), float(z - moved[2]) - 7.5f)
                .norm() < 4)
          set_occupied(grid, x, y, z, true);
  return grid;
}

std::vector<RayRequest> some_rays(int count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> any(-0.3f, 0.3f);
  std::vector<RayRequest> rays;
  for (int i = 0; i < count; ++i) {
    RayRequest& ray = rays.emplace_back();
    const Vec3f from = Vec3f(any(random), any(random), -1.5f) + Vec3f::Constant(0.5f);
    const Vec3f to = Vec3f(any(random), any(random), any(random)) + Vec3f::Constant(0.5f);
    ray.fields[0] = {from, (to - from).normalized() / 0.2f};
    ray.view = i % 2;
  }
  return rays;
}

TEST(CanonicalCells, AreFoundWhereTheDeformationHasThem) {
  FieldPart head;
  head.cube = {Vec3f::Constant(-0.1f), 0.2f};
  const float cell = head.cube.side / kCells;
  // Canonical minus posed: where the blob is posed, all lies two cells further up and one back.
  const std::vector<WarpLattice> lattices{
      constant_lattice(head.cube.origin, head.cube.side, Vec3f::Zero()),
      constant_lattice(head.cube.origin, head.cube.side, Vec3f(0, -2 * cell, cell))};
  const std::array<OccupancyGrid, 2> moved{blob({0, 0, 0}), blob({0, 2, -1})};
  const OccupancyGrid rest = blob({0, 0, 0}), all = make_occupancy(kCells, true),
                      nothing = make_occupancy(kCells, false);
  const std::vector<RayRequest> rays = some_rays(300);

  MarchVolumes through;
  through.fields[0] = march_volume(all, kNoCore, head.cube.side);
  const CanonicalCells cells{&rest, {}, &nothing, head.cube, lattices.data(), lattices.size()};
  through.canonical = &cells;
  SampleBatch found, wanted;
  sample_rays(rays, through, found);
  std::size_t samples = 0;
  for (const int view : {0, 1}) {
    MarchVolumes plain;
    plain.fields[0] = march_volume(moved[std::size_t(view)], kNoCore, head.cube.side);
    sample_rays(rays, plain, wanted);
    for (std::size_t r = 0; r < rays.size(); ++r) {
      if (rays[r].view != view) continue;
      ASSERT_EQ(found.begin[r + 1] - found.begin[r], wanted.begin[r + 1] - wanted.begin[r]) << r;
      for (std::size_t k = 0; k < found.begin[r + 1] - found.begin[r]; ++k, ++samples)
        ASSERT_NEAR(found.placed[16 * r + k].t, wanted.placed[16 * r + k].t, 1e-5f) << r;
      RayRequest a = rays[r], b = rays[r];
      EXPECT_EQ(meets_volume(a, through), meets_volume(b, plain)) << r;
    }
  }
  EXPECT_GT(samples, 1000u);
}

TEST(CanonicalCells, KeptOnesAreOccupiedWhateverIsThere) {
  const OccupancyGrid all = make_occupancy(kCells, true), nothing = make_occupancy(kCells, false);
  const std::vector<RayRequest> rays = some_rays(50);
  MarchVolumes volumes;
  volumes.fields[0] = march_volume(all, kNoCore, 0.2f);
  CanonicalCells cells{&nothing, {}, &all, {Vec3f::Constant(-0.1f), 0.2f}};
  volumes.canonical = &cells;
  SampleBatch batch;
  sample_rays(rays, volumes, batch);
  EXPECT_EQ(batch.begin.back(), 16u * rays.size());
  cells.kept = &nothing;
  sample_rays(rays, volumes, batch);
  EXPECT_EQ(batch.begin.back(), 0u);
}

TEST(CanonicalCells, RememberTheMostAndForgetSlowly) {
  CanonicalState state = make_canonical_state(kCells);
  const auto look = [&](float density) {
    const float place = 0.5f;
    FieldInputs inputs;
    inputs.count = 1, inputs.x = inputs.y = inputs.z = &place;
    add_cell_samples(state, inputs, std::span(&density, 1));
  };
  EXPECT_TRUE(state.occupancy.occupied(1, 2, 3));  // nothing is known yet
  for (int i = 0; i < 10; ++i) look(50);
  const int at = kCells / 2;
  EXPECT_TRUE(state.occupancy.occupied(at, at, at));
  EXPECT_TRUE(state.occupancy.occupied(at - 1, at + 1, at));  // and its neighbours
  EXPECT_FALSE(state.occupancy.occupied(at + 2, at, at));
  EXPECT_EQ(state.opacity[(std::size_t(at) * kCells + at) * kCells + at], cell_opacity(50, kCells));
  int looks = 0;
  while (state.occupancy.occupied(at, at, at) && looks < 100) look(0), ++looks;
  EXPECT_EQ(looks, int(std::ceil(std::log(kCellThreshold / 50) / std::log(kCellDecay))));
}

}  // namespace
}  // namespace likeness
