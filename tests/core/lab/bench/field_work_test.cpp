// Claims about core/lab/bench/field_work.h and standard_field.h.
#include "core/lab/bench/field_work.h"

#include <gtest/gtest.h>

#include "core/lab/bench/standard_field.h"

namespace likeness {
namespace {

TEST(FieldWork, TheStandardFieldCostsTheArithmeticItIsKnownBy) {
  const FieldWork work = field_work(standard_field_config());
  EXPECT_EQ(work.forward_flops, 24960);
  // Every multiply-add once more for its weight's gradient and once for its input's, but for the nine
  // harmonics of the direction, which need none.
  EXPECT_EQ(work.training_flops, 3 * 24960 - 2 * 64 * 9);
  constexpr double kSlice = 2 * 32 * (32 + 2);
  EXPECT_EQ(work.forward_dots, work.forward_flops - kSlice);
  EXPECT_EQ(work.training_dots, work.training_flops - 3 * kSlice);
}

TEST(FieldWork, TheStandardFieldReadsEveryCornerOnceAndTheAmbientOnesTwiceInTraining) {
  const FieldWork work = field_work(standard_field_config());
  ASSERT_EQ(work.tables.size(), 32u);
  double forward = 0, training = 0, updates = 0;
  std::size_t largest = 0;
  for (const TableWork& t : work.tables) {
    forward += t.forward_reads, training += t.training_reads, updates += t.updates;
    largest = std::max(largest, t.bytes);
  }
  EXPECT_EQ(forward, 16 * 8 + 16 * 4);
  EXPECT_EQ(training, 16 * 8 + 2 * 16 * 4);
  EXPECT_EQ(updates, 16 * 8 + 16 * 4);
  EXPECT_EQ(largest, (std::size_t{1} << 16) * 2 * sizeof(float));
  EXPECT_EQ(work.tables.back().bytes, (std::size_t{1} << 14) * 2 * sizeof(float));
}

TEST(FieldWork, TheFloorIsTheSumOfItsPartsAtTheCeilings) {
  const FieldWork work{1000, 3000, {{1 << 15, 8, 16, 8}}};
  const Ceilings ceilings{1, 100, 20, {{1 << 15, 2000, 1000}}};
  EXPECT_NEAR(forward_floor_seconds(work, ceilings), 10e-9 + 4e-9, 1e-15);
  EXPECT_NEAR(training_floor_seconds(work, ceilings), 30e-9 + 8e-9 + 8e-9, 1e-15);
}

TEST(FieldWork, InBf16NetworksHaveTheirOwnPeakAndTablesThatAreReadHalfTheBytes) {
  const FieldWork work{1000, 3000, {{1 << 17, 8, 12, 8, true}, {1 << 17, 8, 8, 8, false}}, 600, 2000};
  const Ceilings ceilings{1, 100, 20, {{1 << 16, 2000, 2000}, {1 << 17, 1000, 1000}}, 200};
  const auto bf16 = FieldPrecision::bf16;
  EXPECT_NEAR(forward_floor_seconds(work, ceilings, bf16), 4e-9 + 3e-9 + 4e-9 + 8e-9, 1e-15);
  // The gradient of the point reads the tables themselves.
  EXPECT_NEAR(training_floor_seconds(work, ceilings, bf16),
              10e-9 + 10e-9 + (4e-9 + 4e-9 + 8e-9) + (8e-9 + 8e-9), 1e-15);
}

TEST(StandardBatch, RepeatsItselfStaysInTheCubeAndGivesEveryRayOneView) {
  const StandardBatch batch = standard_batch(standard_field_config(), 1000, 3);
  const StandardBatch again = standard_batch(standard_field_config(), 1000, 3);
  EXPECT_EQ(batch.x, again.x);
  EXPECT_EQ(batch.latents, again.latents);
  for (std::size_t n = 0; n < 1000; ++n) {
    for (const float p : {batch.x[n], batch.y[n], batch.z[n]}) EXPECT_TRUE(p >= 0 && p <= 1) << p;
    EXPECT_EQ(batch.view[n], batch.view[n / 16 * 16]);
    EXPECT_EQ(batch.dx[n], batch.dx[n / 16 * 16]);
    EXPECT_LT(std::size_t(batch.view[n]), batch.views);
  }
}

}  // namespace
}  // namespace likeness
