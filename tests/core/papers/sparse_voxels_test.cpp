// Claims about values stored in sparse voxels.
#include "core/papers/sparse_voxels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/train/random_stream.h"

namespace likeness {
namespace {

// A ball of soft density around the cube's middle, and two further values.
double ball_density(double x, double y, double z) {
  const double r = std::sqrt((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5) + (z - 0.5) * (z - 0.5));
  return 200 / (1 + std::exp((r - 0.25) / 0.02));
}
double wave(double x, double y, double z) { return std::sin(5 * x + 3 * y) * std::cos(4 * z); }

template <class Density, class Value>
VoxelSource analytic(Density density, Value value) {
  return {[=](const FieldSamples& places, std::vector<float>& sigma) {
            sigma.resize(places.count());
            for (std::size_t i = 0; i < sigma.size(); ++i)
              sigma[i] = float(density(places.x[i], places.y[i], places.z[i]));
          },
          [=](const FieldSamples& places, std::span<float> values) {
            for (std::size_t i = 0; i < places.count(); ++i) {
              values[2 * i] = float(value(places.x[i], places.y[i], places.z[i]));
              values[2 * i + 1] = 1 - values[2 * i];
            }
          }};
}

struct Errors {
  double density = 0, value = 0;  // largest
};
Errors errors_of(const SparseVoxels& voxels) {
  Errors worst;
  RandomStream random(3, 0, 0);
  for (int k = 0; k < 20000; ++k) {
    const float x = random.uniform(), y = random.uniform(), z = random.uniform();
    float got[3] = {0, 0, 0};
    const VoxelPlace place = find_place(voxels, x, y, z);
    if (place.node != nullptr) interpolate(voxels, place, 3, got);
    worst.density = std::max(worst.density, std::abs(double(got[0]) - ball_density(x, y, z)));
    if (place.node != nullptr) worst.value = std::max(worst.value, std::abs(double(got[1]) - wave(x, y, z)));
  }
  return worst;
}

TEST(SparseVoxels, WhatIsLinearAlongEachAxisIsFoundExactly) {
  const auto linear = [](double x, double y, double z) { return 1 + x - 2 * y * z + 3 * x * y * z; };
  const auto density = [&](double x, double y, double z) { return 10 + linear(x, y, z); };
  const SparseVoxels voxels = bake_voxels(16, 3, {}, analytic(density, linear));
  ASSERT_EQ(voxels.stored_blocks(), 8u);
  RandomStream random(1, 0, 0);
  for (int k = 0; k < 2000; ++k) {
    const float x = random.uniform(), y = random.uniform(), z = random.uniform();
    const VoxelPlace place = find_place(voxels, x, y, z);
    ASSERT_NE(place.node, nullptr);
    float got[3];
    interpolate(voxels, place, 3, got);
    EXPECT_NEAR(got[0], density(x, y, z), 1e-4);
    EXPECT_NEAR(got[1], linear(x, y, z), 1e-5);
    EXPECT_NEAR(got[1] + got[2], 1, 1e-5);
  }
}

TEST(SparseVoxels, ErrorOfACurvedFieldFallsWithTheSquareOfTheCells) {
  const Errors coarse = errors_of(bake_voxels(64, 3, {}, analytic(ball_density, wave))),
               fine = errors_of(bake_voxels(128, 3, {}, analytic(ball_density, wave)));
  EXPECT_LT(fine.value, 0.3 * coarse.value);
  EXPECT_LT(fine.value, 5e-4);
  EXPECT_LT(fine.density, 0.35 * coarse.density);
  EXPECT_LT(fine.density, 0.005 * 200);
}

TEST(SparseVoxels, OnlyBlocksThatHoldSomethingAreStored) {
  OccupancyGrid left = make_occupancy(24, false);  // its cells are no part of the blocks
  for (int z = 0; z < 24; ++z)
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 12; ++x) set_occupied(left, x, y, z, true);
  const VoxelSource source = analytic(ball_density, wave);
  const SparseVoxels all = bake_voxels(64, 3, {}, source), half = bake_voxels(64, 3, left, source);
  EXPECT_LT(all.stored_blocks(), 8u * 8 * 8);
  EXPECT_GT(all.stored_blocks(), 8u);
  EXPECT_EQ(2 * half.stored_blocks(), all.stored_blocks());
  EXPECT_NE(find_place(half, 0.4f, 0.5f, 0.5f).node, nullptr);
  EXPECT_EQ(find_place(half, 0.6f, 0.5f, 0.5f).node, nullptr);
  EXPECT_NE(find_place(all, 0.6f, 0.5f, 0.5f).node, nullptr);
  EXPECT_EQ(find_place(all, 0.01f, 0.01f, 0.01f).node, nullptr);  // too thin
  EXPECT_EQ(all.bytes(), all.stored_blocks() * 9 * 9 * 9 * 3 * 4 + 8 * 8 * 8 * 4);
}

TEST(SparseVoxels, WhatADeformationMovesIsStoredWhereItLies) {
  OccupancyGrid posed =
      make_occupancy(16, false);  // one cell, which the second view carries to the other side
  set_occupied(posed, 3, 8, 8, true);
  const auto carry = [](FieldSamples& samples) {
    for (std::size_t i = 0; i < samples.count(); ++i)
      if (samples.view[i] == 1) samples.x[i] += 0.5f;
  };
  const OccupancyGrid moved = moved_occupancy(posed, 2, carry);
  for (int x = 0; x < 16; ++x)
    EXPECT_EQ(moved.occupied(x, 8, 8), std::abs(x - 3) <= 1 || std::abs(x - 11) <= 1) << x;
  EXPECT_TRUE(moved.occupied(11, 7, 9));
  EXPECT_FALSE(moved.occupied(11, 6, 8));
  // Carried out of the cube it lies at its border; nothing stays nothing, and no grid is one that holds all.
  const OccupancyGrid beyond =
      moved_occupancy(posed, 1, [](FieldSamples& samples) { std::ranges::fill(samples.x, 1.5f); });
  EXPECT_TRUE(beyond.occupied(15, 8, 8));
  EXPECT_FALSE(beyond.occupied(3, 8, 8));
  EXPECT_EQ(moved_occupancy(make_occupancy(16, false), 2, carry).bits, make_occupancy(16, false).bits);
  EXPECT_EQ(moved_occupancy({}, 2, carry).resolution, 0);
}

TEST(SparseVoxels, OutsideTheCubeNothingIsStored) {
  const auto full = [](double, double, double) { return 100.0; };
  const SparseVoxels voxels = bake_voxels(8, 3, {}, analytic(full, wave));
  EXPECT_NE(find_place(voxels, 0, 1, 0.5f).node, nullptr);  // its faces belong to it
  EXPECT_EQ(find_place(voxels, -1e-3f, 0.5f, 0.5f).node, nullptr);
  EXPECT_EQ(find_place(voxels, 0.5f, 1.001f, 0.5f).node, nullptr);
  EXPECT_EQ(find_place(voxels, 0.5f, 0.5f, std::nanf("")).node, nullptr);
}

TEST(SparseVoxels, EightChannelsInVectorsAreTheSameAsOneByOne) {
  const SparseVoxels three = bake_voxels(32, 3, {}, analytic(ball_density, wave));
  const SparseVoxels eight = with_channels(three, 5, [](const FieldSamples& places, std::span<float> values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = float(i % 5 + 1) * places.x[i / 5] - places.z[i / 5];
  });
  EXPECT_EQ(eight.blocks, three.blocks);
  RandomStream random(5, 0, 0);
  int met = 0;
  for (int k = 0; k < 2000; ++k) {
    const float x = random.uniform(), y = random.uniform(), z = random.uniform();
    const VoxelPlace at = find_place(eight, x, y, z);
    if (at.node == nullptr) continue;
    ++met;
    float once[8], each[8], base[3];
    interpolate(eight, at, 8, once);
    interpolate(eight, at, 7, each);
    interpolate(three, find_place(three, x, y, z), 3, base);
    for (int i = 0; i < 7; ++i) EXPECT_NEAR(once[i], each[i], 1e-4f);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(once[i], base[i], 1e-4f);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(once[3 + i], float(i + 1) * x - z, 1e-5f);
  }
  EXPECT_GT(met, 100);
}

}  // namespace
}  // namespace likeness
