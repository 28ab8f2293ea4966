#include "core/base/quantile.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

TEST(Quantile, IsTheNearestRank) {
  const std::vector<int> values{30, 10, 50, 20, 40};
  EXPECT_EQ(quantile(values, 0), 10);
  EXPECT_EQ(quantile(values, 0.3), 20);
  EXPECT_EQ(quantile(values, 0.9), 50);
  EXPECT_EQ(quantile(values, 1), 50);
}

TEST(Quantile, TheMedianOfAnEvenNumberIsTheUpperOne) {
  EXPECT_EQ(median<double>({4, 1, 3, 2}), 3);
  EXPECT_EQ(median<double>({7}), 7);
}

TEST(Quantile, OfNoValuesIsZero) { EXPECT_EQ(median(std::vector<float>()), 0.f); }

}  // namespace
}  // namespace likeness
