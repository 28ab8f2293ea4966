// Claims about conversions, crop and resampling of pictures.
#include "core/image/image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "tests/core/image/noise.h"

namespace likeness {
namespace {

double mean(const Image8& image) {
  return std::accumulate(image.data.begin(), image.data.end(), 0.0) / double(image.data.size());
}

TEST(ToBytes, InvertsToFloatForEveryValue) {
  Image8 ramp(256, 1, 1);
  std::iota(ramp.data.begin(), ramp.data.end(), std::uint8_t(0));
  EXPECT_EQ(to_bytes(to_float(ramp)).data, ramp.data);
}

TEST(ToBytes, ClampsValuesOutsideAndTurnsNanIntoBlack) {
  Image image(4, 1, 1);
  image.data = {-3.0f, 7.0f, std::numeric_limits<float>::quiet_NaN(), 0.5f};
  EXPECT_EQ(to_bytes(image).data, (std::vector<std::uint8_t>{0, 255, 0, 128}));
}

TEST(Crop, CopiesTheRectangleAndRepeatsTheBorderOutside) {
  const Image8 image = noise(7, 5, 3);
  for (const auto& [x0, y0] : {std::pair{2, 1}, {-4, -3}, {5, 3}, {-20, 2}, {3, 40}}) {
    const Image8 part = crop(image, x0, y0, 6, 4);
    ASSERT_EQ(part.width, 6);
    ASSERT_EQ(part.height, 4);
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 6; ++x) {
        const auto* expected = image.at(std::clamp(x0 + x, 0, 6), std::clamp(y0 + y, 0, 4));
        for (int c = 0; c < 3; ++c)
          ASSERT_EQ(part.at(x, y)[c], expected[c]) << x0 << ' ' << y0 << ' ' << x << ' ' << y;
      }
    }
  }
}

TEST(Resize, HalvingAveragesBlocksOfFour) {
  const Image8 image = noise(16, 10, 3), half = resize(image, 8, 5);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 8; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double expected = 0.25 * (image.at(2 * x, 2 * y)[c] + image.at(2 * x + 1, 2 * y)[c] +
                                        image.at(2 * x, 2 * y + 1)[c] + image.at(2 * x + 1, 2 * y + 1)[c]);
        EXPECT_NEAR(half.at(x, y)[c], expected, 0.51);
      }
    }
  }
}

TEST(Resize, ShrinkingByAnyRatioKeepsTheMean) {
  // Area filtering gives every source pixel the same total weight.
  const Image8 image = noise(97, 61, 1);
  for (const auto& [w, h] : {std::pair{64, 37}, {96, 60}, {10, 10}, {1, 1}}) {
    EXPECT_NEAR(mean(resize(image, w, h)), mean(image), 0.6) << w << " x " << h;
  }
}

TEST(Resize, EnlargingKeepsALinearRampLinear) {
  Image8 ramp(16, 3, 1);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 16; ++x) *ramp.at(x, y) = std::uint8_t(10 * x);
  }
  const Image8 large = resize(ramp, 64, 3);
  for (int x = 4; x < 60; ++x) EXPECT_NEAR(*large.at(x, 1), 10 * ((x + 0.5) / 4 - 0.5), 0.51) << x;
}

TEST(Resize, AConstantPictureStaysConstant) {
  const Image8 flat(33, 21, 4, 201);
  for (const auto& [w, h] : {std::pair{10, 50}, {50, 10}, {7, 7}, {100, 90}}) {
    for (const auto v : resize(flat, w, h).data) ASSERT_EQ(v, 201);
  }
}

TEST(Enlarge, KeepsRampsInsideAndNeverRings) {
  Image ramp(8, 6, 2), step(8, 6, 2);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 8; ++x) {
      ramp.at(x, y)[0] = float(x), ramp.at(x, y)[1] = float(y);
      step.at(x, y)[0] = x < 4 ? 0.f : 1.f, step.at(x, y)[1] = y < 3 ? 1.f : 0.f;
    }
  const Image large = enlarge(ramp, 16, 13), edge = enlarge(step, 16, 13);
  for (int y = 0; y < 13; ++y)
    for (int x = 0; x < 16; ++x) {
      const double at_x = (x + 0.5) / 2 - 0.5, at_y = (y + 0.5) * 6 / 13 - 0.5;
      if (at_x >= 1 && at_x <= 6) {
        EXPECT_NEAR(large.at(x, y)[0], at_x, 1e-5);
      }
      if (at_y >= 1 && at_y <= 4) {
        EXPECT_NEAR(large.at(x, y)[1], at_y, 1e-5);
      }
      for (int c = 0; c < 2; ++c) {
        EXPECT_GE(edge.at(x, y)[c], 0);
        EXPECT_LE(edge.at(x, y)[c], 1);
      }
    }
  EXPECT_EQ(enlarge(step, 8, 6).data, step.data);
}

TEST(Resize, ToTheSameSizeChangesNothing) {
  const Image8 image = noise(19, 23, 3);
  EXPECT_EQ(resize(image, 19, 23).data, image.data);
}

}  // namespace
}  // namespace likeness
