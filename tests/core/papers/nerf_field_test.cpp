// Claims about the baselines' fields: gradients, and what each reads.
#include "core/papers/nerf_field.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

NerfConfig small_config(int conditions, bool slice) {
  NerfConfig c;
  c.position_frequencies = 3, c.direction_frequencies = 2;
  c.width = 12, c.layers = 4, c.skip = 2;
  c.condition_count = conditions;
  c.slice = slice;
  c.slice_width = 8, c.slice_layers = 3, c.slice_skip = 2, c.slice_frequencies = 2;
  return c;
}

NerfInputs<double> random_inputs(int conditions, int count) {
  NerfInputs<double> in;
  in.position = (Eigen::MatrixXd::Random(3, count).array() + 1) / 2;
  in.direction = Eigen::MatrixXd::Random(3, count).colwise().normalized();
  in.condition = Eigen::MatrixXd::Random(conditions, count);
  return in;
}

class NerfGradients : public testing::TestWithParam<std::pair<int, bool>> {};

TEST_P(NerfGradients, AgreeWithFiniteDifferences) {
  const auto [conditions, slice] = GetParam();
  NerfField<double> field = in_double(make_nerf_field(small_config(conditions, slice), 3));
  const NerfInputs<double> in = random_inputs(conditions, 5);
  const NerfOutputs<double> pull{Eigen::MatrixXd::Random(1, 5), Eigen::MatrixXd::Random(3, 5)};
  const auto loss = [&] {
    NerfTape<double> tape;
    const NerfOutputs<double> out = nerf_forward(field, in, tape);
    return out.sigma.cwiseProduct(pull.sigma).sum() + out.colour.cwiseProduct(pull.colour).sum();
  };
  NerfTape<double> tape;
  const NerfOutputs<double> out = nerf_forward(field, in, tape);
  std::vector<double> gradients(field.parameters.size());
  nerf_backward(field, tape, out, pull, gradients);
  double largest = 0;
  for (std::size_t i = 0; i < gradients.size(); ++i) {
    constexpr double kStep = 1e-6;
    const double kept = field.parameters[i];
    field.parameters[i] = kept + kStep;
    const double above = loss();
    field.parameters[i] = kept - kStep;
    const double below = loss();
    field.parameters[i] = kept;
    const double difference = (above - below) / (2 * kStep);
    EXPECT_NEAR(gradients[i], difference, 1e-6 + 1e-5 * std::abs(difference)) << i;
    largest = std::max(largest, std::abs(difference));
  }
  EXPECT_GT(largest, 0.1);
  if (slice) {  // the slice is reached, too
    const std::size_t own = parameter_count(field.slice);
    ASSERT_GT(own, 0u);
    double reached = 0;
    for (std::size_t i = 0; i < own; ++i) reached = std::max(reached, std::abs(gradients[i]));
    EXPECT_GT(reached, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, NerfGradients,
                         testing::Values(std::pair{0, false}, std::pair{3, false}, std::pair{3, true}));

TEST(NerfField, ReadsTheExpressionOnlyWhereItHasOne) {
  for (const bool slice : {false, true}) {
    const NerfField<double> field = in_double(make_nerf_field(small_config(3, slice), 3));
    NerfInputs<double> in = random_inputs(3, 6);
    NerfTape<double> tape;
    const Eigen::MatrixXd before = nerf_forward(field, in, tape).sigma;
    in.condition.array() += 0.5;
    EXPECT_GT((nerf_forward(field, in, tape).sigma - before).norm(), 1e-6) << slice;
  }
}

TEST(NerfField, DensityAloneIsTheSameDensity) {
  const NerfField<double> field = in_double(make_nerf_field(small_config(3, true), 9));
  const NerfInputs<double> in = random_inputs(3, 6);
  NerfTape<double> a, b;
  const NerfOutputs<double> all = nerf_forward(field, in, a);
  const NerfOutputs<double> density = nerf_forward(field, in, b, NerfWanted::density);
  EXPECT_EQ(all.sigma, density.sigma);
  EXPECT_EQ(density.colour.cols(), 0);
  EXPECT_GE(all.colour.minCoeff(), 0);
  EXPECT_LE(all.colour.maxCoeff(), 1);
}

TEST(NerfField, HasTheSizeOfTheOriginal) {
  // Mildenhall et al. 2020, figure 7: encodings of 63 and 27 numbers, the position read again after the fifth
  // layer.
  const std::size_t trunk = (63 * 256 + 256) + 6 * (256 * 256 + 256) + ((256 + 63) * 256 + 256);
  const std::size_t heads = (256 + 1) + (256 * 256 + 256) + ((256 + 27) * 128 + 128) + (128 * 3 + 3);
  EXPECT_EQ(make_nerf_field({}, 1).parameters.size(), trunk + heads);
}

}  // namespace
}  // namespace likeness
