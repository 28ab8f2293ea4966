// Claims about picture differences, SSIM and GMSD against their definitions written out plainly.
#include "core/image/metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace likeness {
namespace {

Image smooth_noise(int width, int height, int channels, unsigned seed) {
  Image image(width, height, channels);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-0.1f, 0.1f);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < channels; ++c) {
        image.at(x, y)[c] =
            std::clamp(0.5f + 0.3f * std::sin(0.3f * x + c) * std::cos(0.2f * y) + uniform(random), 0.f, 1.f);
      }
    }
  }
  return image;
}

// Every window on its own, in double, straight from the definition.
double plain_ssim(const Image& a, const Image& b) {
  double total = 0;
  int count = 0;
  for (int c = 0; c < a.channels; ++c) {
    for (int y = 5; y < a.height - 5; ++y) {
      for (int x = 5; x < a.width - 5; ++x) {
        double w = 0, ma = 0, mb = 0, vaa = 0, vbb = 0, vab = 0;
        const auto visit = [&](auto&& f) {
          for (int j = -5; j <= 5; ++j) {
            for (int i = -5; i <= 5; ++i)
              f(std::exp(-(i * i + j * j) / 4.5), a.at(x + i, y + j)[c], b.at(x + i, y + j)[c]);
          }
        };
        visit([&](double g, double va, double vb) { w += g, ma += g * va, mb += g * vb; });
        ma /= w, mb /= w;
        visit([&](double g, double va, double vb) {
          vaa += g * (va - ma) * (va - ma), vbb += g * (vb - mb) * (vb - mb),
              vab += g * (va - ma) * (vb - mb);
        });
        vaa /= w, vbb /= w, vab /= w;
        total += (2 * ma * mb + 1e-4) * (2 * vab + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (vaa + vbb + 9e-4));
        ++count;
      }
    }
  }
  return total / count;
}

TEST(Mse, OfAConstantOffsetIsItsSquare) {
  const Image a(9, 7, 3, 0.5f), b(9, 7, 3, 0.6f);
  EXPECT_NEAR(mse(a, b), 0.01, 1e-7);
  EXPECT_NEAR(psnr_from_mse(mse(a, b)), 20, 1e-4);
  EXPECT_TRUE(std::isinf(psnr_from_mse(mse(a, a))));
}

TEST(Mse, WithAMaskCountsOnlyMaskedPixels) {
  Image a(8, 8, 3, 0.2f), b = a;
  Image8 mask(8, 8, 1);
  for (int c = 0; c < 3; ++c) b.at(3, 4)[c] += 0.5f, b.at(0, 0)[c] += 0.3f;
  *mask.at(3, 4) = 1, *mask.at(5, 5) = 255;
  EXPECT_NEAR(mse(a, b, mask), 0.25 / 2, 1e-6);
  EXPECT_TRUE(std::isnan(mse(a, b, Image8(8, 8, 1))));
}

TEST(Mse, OverMaskAndComplementAddsUpToTheWhole) {
  const Image a = smooth_noise(20, 15, 3, 1), b = smooth_noise(20, 15, 3, 2);
  Image8 mask(20, 15, 1), rest(20, 15, 1);
  for (std::size_t i = 0; i < mask.data.size(); ++i) (i % 3 ? mask : rest).data[i] = 255;
  EXPECT_NEAR((mse(a, b, mask) * 200 + mse(a, b, rest) * 100) / 300, mse(a, b), 1e-9);
}

TEST(Ssim, AgreesWithItsDefinition) {
  const Image a = smooth_noise(33, 26, 3, 3), b = smooth_noise(33, 26, 3, 4);
  EXPECT_NEAR(ssim(a, b), plain_ssim(a, b), 2e-4);
  EXPECT_LT(ssim(a, b), 0.95);
}

TEST(Ssim, IsOneForEqualPicturesSymmetricAndFallsWithNoise) {
  const Image a = smooth_noise(40, 30, 1, 5), b = smooth_noise(40, 30, 1, 6);
  EXPECT_NEAR(ssim(a, a), 1, 1e-6);
  EXPECT_NEAR(ssim(a, b), ssim(b, a), 1e-6);
  Image worse = b;
  std::mt19937 random(9);
  for (auto& v : worse.data) v += 0.2f * (float(random() & 1023) / 1023 - 0.5f);
  EXPECT_LT(ssim(a, worse), ssim(a, b));
}

TEST(Ssim, WorksOnPicturesSmallerThanItsWindow) {
  const Image a = smooth_noise(6, 4, 3, 1);
  EXPECT_NEAR(ssim(a, a), 1, 1e-5);
}

TEST(Gmsd, IsZeroForEqualPicturesAndForAUniformShiftOfBrightness) {
  const Image a = smooth_noise(32, 32, 3, 1);
  Image brighter = a;
  for (auto& v : brighter.data) v += 0.125f;
  EXPECT_NEAR(gmsd(a, a), 0, 1e-6);
  EXPECT_NEAR(gmsd(a, brighter), 0, 1e-4);
}

TEST(Gmsd, RisesWhenPartOfThePictureIsBlurred) {
  const Image a = smooth_noise(64, 64, 1, 1);
  const auto flattened = [&](int rows) {
    Image b = a;
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < 64; ++x) *b.at(x, y) = 0.5f;
    }
    return b;
  };
  EXPECT_GT(gmsd(a, flattened(8)), 0.01);
  EXPECT_GT(gmsd(a, flattened(24)), gmsd(a, flattened(8)));
}

TEST(Gmsd, OfAStepAgainstAFlatPictureHasTheValueWorkedOutByHand) {
  // Halved, a step of height 1 between columns 7 and 8 has gradient 1 (three rows times 1, over 3) in those
  // two columns and none elsewhere; the similarity there is c / (1 + c), elsewhere 1.
  Image step(32, 32, 1), flat(32, 32, 1);
  for (int y = 0; y < 32; ++y) {
    for (int x = 16; x < 32; ++x) *step.at(x, y) = 1;
  }
  const double c = 170.0 / (255 * 255), low = c / (1 + c), share = 2.0 / 16;
  EXPECT_NEAR(gmsd(step, flat), (1 - low) * std::sqrt(share * (1 - share)), 1e-6);
}

}  // namespace
}  // namespace likeness
