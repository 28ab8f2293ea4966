// Claims about a picture's value between its pixels.
#include "core/image/bilinear.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

// 3 + 2 x - y + 0.5 x y at pixel centres: bilinear within every cell, so it is met exactly everywhere inside.
Image sheet() {
  Image picture(7, 5, 1);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) {
      const float u = float(x) + 0.5f, v = float(y) + 0.5f;
      *picture.at(x, y) = 3 + 2 * u - v + 0.5f * u * v;
    }
  return picture;
}

TEST(Bilinear, ReproducesABilinearSheetAndItsSlopeBetweenPixels) {
  const Image picture = sheet();
  for (const auto& [x, y] : {std::pair{0.5, 0.5}, {1.0, 1.3}, {3.77, 2.02}, {6.3, 4.4}}) {
    ASSERT_TRUE(inside_bilinear(picture, x, y));
    double slope[2];
    EXPECT_NEAR(bilinear(picture, x, y, slope), 3 + 2 * x - y + 0.5 * x * y, 1e-6);
    EXPECT_NEAR(slope[0], 2 + 0.5 * y, 1e-6);
    EXPECT_NEAR(slope[1], -1 + 0.5 * x, 1e-6);
  }
}

TEST(Bilinear, OuterHalfPixelIsOutsideAndExtrapolatesFromTheBorder) {
  const Image picture = sheet();
  EXPECT_FALSE(inside_bilinear(picture, 0.49, 2));
  EXPECT_FALSE(inside_bilinear(picture, 3, 4.5));
  EXPECT_FALSE(inside_bilinear(picture, 6.5, 2));
  EXPECT_NEAR(bilinear(picture, 6.9, 2), 3 + 2 * 6.9 - 2 + 0.5 * 6.9 * 2, 1e-5);
}

// Each channel is met on its own, and places outside have the colour at the border.
TEST(Bilinear, MeetsColoursBetweenTheirPixels) {
  BasicImage<float> picture(4, 3, 3);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x)
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] = float(c + 1) * (2 + 3 * (float(x) + 0.5f) - (float(y) + 0.5f));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(bilinear_colour(picture, 1.7, 2.2)[c], float(c + 1) * (2 + 3 * 1.7f - 2.2f), 1e-5f);
    EXPECT_NEAR(bilinear_colour(picture, -5, 9)[c], picture.at(0, 2)[c], 1e-6f);
    EXPECT_NEAR(bilinear_colour(picture, 9, -5)[c], picture.at(3, 0)[c], 1e-6f);
  }
}

}  // namespace
}  // namespace likeness
