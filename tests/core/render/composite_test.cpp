// Claims about compositing: exact on known media, and gradients that agree with finite differences in double.
#include "core/render/composite.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace likeness {
namespace {

TEST(CompositeRay, HomogeneousMediumHasItsClosedForm) {
  const int n = 16;
  const double sigma_value = 3.7, length = 0.8;
  std::vector<double> sigma(n, sigma_value), dt(n, length / n), colour(3 * n, 0.25);
  const auto out = composite_ray(n, sigma.data(), dt.data(), colour.data());
  EXPECT_NEAR(out.transmittance, std::exp(-sigma_value * length), 1e-12);
  EXPECT_NEAR(out.colour[1], 0.25 * (1 - std::exp(-sigma_value * length)), 1e-12);
}

TEST(CompositeRay, SplittingASampleChangesNothing) {
  const double sigma[] = {5, 2}, dt[] = {0.3, 0.2}, colour[] = {1, 0.5, 0, 0.2, 0.4, 0.9};
  const double sigma_split[] = {5, 5, 2}, dt_split[] = {0.1, 0.2, 0.2};
  const double colour_split[] = {1, 0.5, 0, 1, 0.5, 0, 0.2, 0.4, 0.9};
  const auto a = composite_ray(2, sigma, dt, colour);
  const auto b = composite_ray(3, sigma_split, dt_split, colour_split);
  EXPECT_NEAR(a.transmittance, b.transmittance, 1e-14);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a.colour[c], b.colour[c], 1e-14);
}

// L = weights . (C + T background) + transmittance_weight T.
struct CompositeProblem {
  std::vector<double> sigma, dt, colour;
  double background[3], weights[3], transmittance_weight = 0;

  double loss() const {
    const auto out = composite_ray(int(sigma.size()), sigma.data(), dt.data(), colour.data());
    double sum = transmittance_weight * out.transmittance;
    for (int c = 0; c < 3; ++c) sum += weights[c] * (out.colour[c] + out.transmittance * background[c]);
    return sum;
  }
};

CompositeProblem random_problem(int n, std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  CompositeProblem p;
  for (int i = 0; i < n; ++i) {
    p.sigma.push_back(20 * uniform(engine) * uniform(engine));
    p.dt.push_back(0.01 + 0.2 * uniform(engine));
    for (int c = 0; c < 3; ++c) p.colour.push_back(uniform(engine));
  }
  for (int c = 0; c < 3; ++c) p.background[c] = uniform(engine), p.weights[c] = 2 * uniform(engine) - 1;
  p.transmittance_weight = uniform(engine) - 0.5;
  return p;
}

TEST(CompositeRayBackward, AgreesWithFiniteDifferences) {
  for (const int n : {1, 2, 7, 16}) {
    CompositeProblem p = random_problem(n, std::uint32_t(n));
    std::vector<double> d_sigma(n), d_colour(3 * n);
    const auto forward = composite_ray(n, p.sigma.data(), p.dt.data(), p.colour.data());
    composite_ray_backward(n, p.sigma.data(), p.dt.data(), p.colour.data(), p.background, forward, p.weights,
                           p.transmittance_weight, d_sigma.data(), d_colour.data());
    const auto slope = [&](double& value) {
      const double kept = value, h = 1e-5;
      value = kept + h;
      const double up = p.loss();
      value = kept - h;
      const double down = p.loss();
      value = kept;
      return (up - down) / (2 * h);
    };
    for (int i = 0; i < n; ++i)
      EXPECT_NEAR(d_sigma[i], slope(p.sigma[i]), 1e-8) << "sample " << i << " of " << n;
    for (int i = 0; i < 3 * n; ++i) EXPECT_NEAR(d_colour[i], slope(p.colour[i]), 1e-8);
  }
}

}  // namespace
}  // namespace likeness
