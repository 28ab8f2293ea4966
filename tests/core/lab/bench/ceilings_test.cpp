// Claims about core/lab/bench/ceilings.h.
#include "core/lab/bench/ceilings.h"

#include <cmath>

#include <gtest/gtest.h>

namespace likeness {
namespace {

const Ceilings kMade{1, 100, 20, {{1 << 15, 2000, 1000}, {1 << 17, 1000, 500}, {1 << 19, 500, 250}}};

TEST(Ceilings, EveryFigureOfThisMachineIsFiniteAndPositive) {
  for (const int threads : {1, 2}) {
    const Ceilings c = measure_ceilings(threads, 1e-3);
    EXPECT_EQ(c.threads, threads);
    ASSERT_GE(c.tables.size(), 3u);
    for (const double figure : {c.fma_gflops, c.bandwidth_gbs})
      EXPECT_TRUE(std::isfinite(figure) && figure > 0) << figure;
    for (const TableRate& t : c.tables) {
      EXPECT_TRUE(std::isfinite(t.gather_mps) && t.gather_mps > 0) << t.bytes;
      EXPECT_TRUE(std::isfinite(t.read_modify_write_mps) && t.read_modify_write_mps > 0) << t.bytes;
    }
  }
}

// Two products a lane instead of one, twice as fast at most on any processor of today. A loop that the
// compiler computes only once appears many times faster.
TEST(Ceilings, DotProductsInBf16AreNotFasterThanTheirInstructions) {
  const Ceilings c = measure_ceilings(1, 2e-3);
  if (c.bf16_gflops == 0) GTEST_SKIP() << "this processor has no AVX-512 BF16";
  EXPECT_GT(c.bf16_gflops, 0);
  EXPECT_LT(c.bf16_gflops, 16 * c.fma_gflops);
}

TEST(Ceilings, AccessTimeIsTheMeasuredOneAtMeasuredSizesAndRisesBetweenThem) {
  EXPECT_NEAR(gather_seconds(kMade, 1 << 17), 1e-9, 1e-15);
  EXPECT_NEAR(read_modify_write_seconds(kMade, 1 << 19), 4e-9, 1e-15);
  EXPECT_NEAR(gather_seconds(kMade, 1 << 18), 1.5e-9, 1e-15);  // half-way, by the logarithm of the size
  double before = 0;
  for (std::size_t bytes = 1 << 14; bytes <= (1 << 20); bytes += 1 << 14) {
    EXPECT_GE(gather_seconds(kMade, bytes), before);
    before = gather_seconds(kMade, bytes);
  }
}

TEST(Ceilings, TheBestOfTwoTakesEachFigureByItself) {
  Ceilings other = kMade;
  other.fma_gflops = 90, other.bandwidth_gbs = 30, other.tables[1].gather_mps = 1200;
  other.bf16_gflops = 180;
  const Ceilings best = best_of(kMade, other);
  EXPECT_EQ(best.fma_gflops, 100);
  EXPECT_EQ(best.bandwidth_gbs, 30);
  EXPECT_EQ(best.bf16_gflops, 180);
  EXPECT_EQ(best.tables[1].gather_mps, 1200);
  EXPECT_EQ(best.tables[2].gather_mps, 500);
}

}  // namespace
}  // namespace likeness
