// Claims about compositing at the ends of what densities and steps can be.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/render/composite.h"

namespace likeness {
namespace {

const std::vector<double> kDensities{0, 1e-42, 1e-30, 1e-8, 1, 300, 1e4, 1e8};
const std::vector<double> kSteps{0, 1e-8, 1e-4, 0.01, 0.3, 10};

struct HardRay {
  std::vector<float> sigma, dt, colour;
  int count() const { return int(sigma.size()); }
};

HardRay hard_ray(std::mt19937& random, int count) {
  std::uniform_real_distribution<float> uniform(0, 1);
  HardRay ray;
  for (int i = 0; i < count; ++i) {
    ray.sigma.push_back(float(kDensities[random() % kDensities.size()]));
    ray.dt.push_back(float(kSteps[random() % kSteps.size()]));
    for (int c = 0; c < 3; ++c)
      ray.colour.push_back(random() % 4 == 0 ? float(random() % 2) : uniform(random));
  }
  return ray;
}

// Transmittances as exponentials of sums: no product to underflow, no difference to cancel.
Composited<long double> in_log_space(const HardRay& ray) {
  Composited<long double> out;
  long double depth = 0;
  for (int i = 0; i < ray.count(); ++i) {
    const auto at = std::size_t(i);
    const long double own = static_cast<long double>(ray.sigma[at]) * ray.dt[at];
    const long double weight = std::exp(-depth) * -std::expm1(-own);
    for (std::size_t c = 0; c < 3; ++c) out.colour[c] += weight * ray.colour[3 * at + c];
    depth += own;
  }
  out.transmittance = std::exp(-depth);
  return out;
}

TEST(CompositingStability, ProductsOfTransmittancesAgreeWithLogSpace) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const HardRay ray = hard_ray(random, 1 + int(random() % 64));
    const auto got = composite_ray(ray.count(), ray.sigma.data(), ray.dt.data(), ray.colour.data());
    const auto want = in_log_space(ray);
    EXPECT_NEAR(got.transmittance, want.transmittance, 1e-6);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(got.colour[c], want.colour[c], 2e-6);
  }
}

TEST(CompositingStability, GradientsAreThoseOfDoublesAndFinite) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 2000; ++trial) {
    const HardRay ray = hard_ray(random, 1 + int(random() % 64));
    const auto n = std::size_t(ray.count());
    const std::vector<double> sigma(ray.sigma.begin(), ray.sigma.end()), dt(ray.dt.begin(), ray.dt.end()),
        colour(ray.colour.begin(), ray.colour.end());
    const float background[3] = {0, 1, 0.4f}, slope[3] = {1, -2, 0.5f};
    const double background_d[3] = {0, 1, background[2]}, slope_d[3] = {1, -2, 0.5};
    std::vector<float> d_sigma(n), d_colour(3 * n);
    std::vector<double> e_sigma(n), e_colour(3 * n);
    const auto forward = composite_ray(ray.count(), ray.sigma.data(), ray.dt.data(), ray.colour.data());
    composite_ray_backward(ray.count(), ray.sigma.data(), ray.dt.data(), ray.colour.data(), background,
                           forward, slope, 0.3f, d_sigma.data(), d_colour.data());
    const auto exact = composite_ray(ray.count(), sigma.data(), dt.data(), colour.data());
    composite_ray_backward(ray.count(), sigma.data(), dt.data(), colour.data(), background_d, exact, slope_d,
                           0.3, e_sigma.data(), e_colour.data());
    for (std::size_t i = 0; i < n; ++i) {
      ASSERT_TRUE(std::isfinite(d_sigma[i]));
      EXPECT_NEAR(d_sigma[i], e_sigma[i], 2e-5 * std::max(1e-8, dt[i]));  // by the length it stands for
    }
    for (std::size_t i = 0; i < 3 * n; ++i) EXPECT_NEAR(d_colour[i], e_colour[i], 3e-6);
  }
}

TEST(CompositingStability, CoincidentSamplesCountForNothing) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    HardRay ray = hard_ray(random, 24), doubled;
    for (std::size_t i = 0; i < 24; ++i)
      for (const float share : {1.f, 0.f}) {
        doubled.sigma.push_back(ray.sigma[i]), doubled.dt.push_back(share * ray.dt[i]);
        doubled.colour.insert(doubled.colour.end(), ray.colour.begin() + std::ptrdiff_t(3 * i),
                              ray.colour.begin() + std::ptrdiff_t(3 * i + 3));
      }
    const auto a = composite_ray(ray.count(), ray.sigma.data(), ray.dt.data(), ray.colour.data());
    const auto b =
        composite_ray(doubled.count(), doubled.sigma.data(), doubled.dt.data(), doubled.colour.data());
    EXPECT_EQ(a.transmittance, b.transmittance);
    for (int c = 0; c < 3; ++c) EXPECT_EQ(a.colour[c], b.colour[c]);
  }
}

}  // namespace
}  // namespace likeness
