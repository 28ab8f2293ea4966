// Claims about comparing mattes.
#include "core/lab/truth/matte_truth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace likeness {
namespace {

// A disc of the given radius with a soft rim of one pixel.
Image8 disc(double radius) {
  Image8 matte(100, 100, 1);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) {
      const double inside = radius + 0.5 - std::hypot(x + 0.5 - 50, y + 0.5 - 50);
      *matte.at(x, y) = std::uint8_t(std::lround(255 * std::clamp(inside, 0.0, 1.0)));
    }
  return matte;
}

TEST(CompareMattes, TheTruthHasNoError) {
  const MatteErrors errors = compare_mattes(disc(30), disc(30), 50);
  EXPECT_DOUBLE_EQ(errors.iou, 1);
  EXPECT_EQ(errors.border, 0);
  EXPECT_EQ(errors.hair, 0);
}

TEST(CompareMattes, IouIsThatOfTheAreas) {
  EXPECT_NEAR(compare_mattes(disc(27), disc(30), 50).iou, 27.0 * 27 / (30 * 30), 0.01);
  EXPECT_NEAR(compare_mattes(disc(30), disc(27), 50).iou, 27.0 * 27 / (30 * 30), 0.01);
}

TEST(CompareMattes, HairIsTheBorderAboveTheEars) {
  // The upper half is a pixel too small, the lower half true.
  Image8 found = disc(30);
  const Image8 small = disc(29);
  for (int y = 0; y < 50; ++y)
    for (int x = 0; x < 100; ++x) *found.at(x, y) = *small.at(x, y);
  const MatteErrors errors = compare_mattes(found, disc(30), 50);
  EXPECT_NEAR(errors.hair, 2 * errors.border, 0.1 * errors.hair);
  EXPECT_GT(errors.hair, 0.1);  // one of about six pixels across the border
  EXPECT_EQ(compare_mattes(found, disc(30), 0).hair, 0);
}

}  // namespace
}  // namespace likeness
