// Claims about core/field/field_reference.h: its gradients are those of its outputs, by finite differences in
// double.
#include "core/field/field_reference.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/core/field/random_field.h"

namespace likeness {
namespace {

constexpr double kStep = 1e-6;

struct FieldProblem {
  FieldConfig config;
  std::vector<double> parameters;
  ReferenceSamples<double> samples;
  ReferenceOutputs<double> weights;  // the loss is the sum of outputs times these
};

FieldProblem make_problem(const FieldConfig& config, std::uint32_t seed) {
  const Field field = trained_like_field(config, seed);
  const Batch batch = random_batch(config, 12, 3, seed + 7);
  FieldProblem p{config,
                 {field.parameters.begin(), field.parameters.end()},
                 reference_samples<double>(config, batch.inputs(), batch.views),
                 {}};
  p.weights.sigma.assign(batch.sigma.begin(), batch.sigma.end());
  p.weights.red.assign(batch.red.begin(), batch.red.end());
  p.weights.green.assign(batch.green.begin(), batch.green.end());
  p.weights.blue.assign(batch.blue.begin(), batch.blue.end());
  return p;
}

double loss(const FieldProblem& p) {
  const auto out = reference_forward<double>(p.config, p.parameters, p.samples);
  double sum = 0;
  for (std::size_t n = 0; n < out.sigma.size(); ++n) {
    sum += out.sigma[n] * p.weights.sigma[n] + out.red[n] * p.weights.red[n] +
           out.green[n] * p.weights.green[n] + out.blue[n] * p.weights.blue[n];
  }
  return sum;
}

double difference(FieldProblem& p, double& value) {
  const double kept = value;
  value = kept + kStep;
  const double above = loss(p);
  value = kept - kStep;
  const double below = loss(p);
  value = kept;
  return (above - below) / (2 * kStep);
}

ReferenceGradients<double> gradients_of(const FieldProblem& p) {
  return reference_backward<double>(p.config, p.parameters, p.samples, p.weights);
}

double largest(std::span<const double> values) {
  double m = 0;
  for (double v : values) m = std::max(m, std::abs(v));
  return m;
}

class FieldReference : public testing::TestWithParam<NamedConfig> {};

TEST_P(FieldReference, GradientOfEveryParameterBlockMatchesFiniteDifferences) {
  FieldProblem p = make_problem(GetParam().config, 11);
  const auto g = gradients_of(p);
  std::mt19937 random(5);
  for (const ParameterBlock& block : parameter_layout(p.config)) {
    const std::span<const double> analytic(g.parameters.data() + block.offset, block.count);
    const double scale = largest(analytic);
    EXPECT_GT(scale, 0.0) << block.name << " has no gradient";
    int touched = 0;
    for (int trial = 0; trial < 4000 && touched < 24; ++trial) {
      const std::size_t i = random() % block.count;
      if (analytic[i] == 0.0 && trial > 4) continue;  // of the untouched, a few
      ++touched;
      EXPECT_NEAR(difference(p, p.parameters[block.offset + i]), analytic[i], 2e-6 * scale + 1e-8)
          << block.name << "[" << i << "]";
    }
    EXPECT_GE(touched, std::min<int>(3, int(block.count))) << block.name;
  }
}

TEST_P(FieldReference, GradientOfConditionsLatentsAndPositionsMatchesFiniteDifferences) {
  FieldProblem p = make_problem(GetParam().config, 23);
  const auto g = gradients_of(p);
  const auto check = [&](std::vector<double>& values, const std::vector<double>& analytic, const char* name) {
    ASSERT_EQ(values.size(), analytic.size()) << name;
    const double scale = largest(analytic);
    EXPECT_EQ(values.empty(), scale == 0.0) << name;
    for (std::size_t i = 0; i < values.size(); ++i) {
      EXPECT_NEAR(difference(p, values[i]), analytic[i], 2e-6 * scale + 1e-8) << name << "[" << i << "]";
    }
  };
  check(p.samples.conditions, g.conditions, "conditions");
  check(p.samples.latents, g.latents, "latents");
  check(p.samples.x, g.x, "x");
  check(p.samples.y, g.y, "y");
  check(p.samples.z, g.z, "z");
}

INSTANTIATE_TEST_SUITE_P(Configs, FieldReference, testing::ValuesIn(small_configs()),
                         [](const auto& info) { return info.param.name; });

// The field is continuous across a cell border but its slope jumps there; on the border itself the gradient
// is that of the cell above, as floor() chooses it, and at the upper end of the cube that of the last cell.
TEST(FieldReferenceBorder, SlopeOnACellBorderIsThatOfTheCellAbove) {
  FieldConfig config = small_configs()[0].config;
  config.position = {3, 1, 4, 10, 4, 4};
  FieldProblem p = make_problem(config, 31);
  p.samples.x.assign(12, 0.5);
  const auto g = gradients_of(p);
  double above = 0, below = 0, analytic = 0;
  const double here = loss(p);
  p.samples.x.assign(12, 0.5 + kStep);
  above = (loss(p) - here) / kStep;
  p.samples.x.assign(12, 0.5 - kStep);
  below = (here - loss(p)) / kStep;
  for (double v : g.x) analytic += v;
  EXPECT_NEAR(analytic, above, 1e-3 * std::abs(above));
  EXPECT_GT(std::abs(above - below), 1e-2 * std::abs(above));

  p.samples.x.assign(12, 1.0);
  const auto end = gradients_of(p);
  const double there = loss(p);
  p.samples.x.assign(12, 1.0 - kStep);
  below = (there - loss(p)) / kStep;
  analytic = 0;
  for (double v : end.x) analytic += v;
  EXPECT_NEAR(analytic, below, 1e-3 * std::abs(below));
}

TEST(FieldReferenceDensity, IsContinuousWithItsSlopeAtTheKneeAndFiniteFarBeyond) {
  FieldProblem p = make_problem(small_configs()[0].config, 41);
  const auto layout = parameter_layout(p.config);
  const auto bias = std::find_if(layout.begin(), layout.end(), [&](const ParameterBlock& b) {
    return b.name == "density.biases" + std::to_string(p.config.density_layers);
  });
  ASSERT_NE(bias, layout.end());
  double& shift = p.parameters[bias->offset];
  for (double value : {8.0, 9.0, 10.0, 12.0}) {
    shift = value;
    const double analytic = gradients_of(p).parameters[bias->offset];
    EXPECT_NEAR(difference(p, shift), analytic, 1e-5 * std::abs(analytic));
  }
  shift = 1e6;
  for (double sigma : reference_forward<double>(p.config, p.parameters, p.samples).sigma) {
    EXPECT_TRUE(std::isfinite(sigma));
    EXPECT_GT(sigma, 1e6);
  }
}

TEST(FieldReferenceSlice, MovesWithTheExpressionAndStaysInsideTheUnitInterval) {
  FieldProblem p = make_problem(small_configs()[0].config, 51);
  const auto before = reference_slice<double>(p.config, p.parameters, p.samples);
  for (double& v : p.samples.conditions) v *= 50;
  const auto after = reference_slice<double>(p.config, p.parameters, p.samples);
  ASSERT_EQ(before.size(), 24u);
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_LE(std::abs(after[i]), 1.0);
    EXPECT_NE(before[i], after[i]);
  }
}

}  // namespace
}  // namespace likeness
