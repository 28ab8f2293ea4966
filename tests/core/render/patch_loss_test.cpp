// Claims about the loss on patches of rays: its slopes, by themselves and through the processor's learner.
#include "core/render/patch_loss.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/core/render/two_fields.h"

namespace likeness {
namespace {

std::vector<float> random_map(std::size_t rays, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::vector<float> map(2 * rays);
  for (float& value : map) value = normal(random);
  return map;
}

TEST(PatchLoss, GradientMatchesFiniteDifferences) {
  constexpr std::size_t kRays = 9;
  constexpr double kWeight = 0.7, kStep = 1e-6;
  const std::vector<float> map = random_map(kRays, 1);
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0, 0.1);
  std::vector<double> difference(3 * kRays), slopes(3 * kRays), unused(3 * kRays);
  for (double& value : difference) value = normal(random);
  EXPECT_GT(patch_loss<double>(map, kWeight, difference, slopes), 0);
  for (std::size_t i = 0; i < difference.size(); ++i) {
    const double at = difference[i];
    difference[i] = at + kStep;
    const double above = patch_loss<double>(map, kWeight, difference, unused);
    difference[i] = at - kStep;
    const double below = patch_loss<double>(map, kWeight, difference, unused);
    difference[i] = at;
    EXPECT_NEAR(slopes[i], (above - below) / (2 * kStep), 1e-8) << i;
  }
}

TEST(PatchLoss, IsZeroWithZeroGradientWhereThePicturesAgree) {
  const std::vector<float> map = random_map(4, 3);
  const std::vector<double> difference(12, 0.0);
  std::vector<double> slopes(12, 1.0);
  EXPECT_EQ(patch_loss<double>(map, 1.0, difference, slopes), 0);
  for (const double slope : slopes) EXPECT_EQ(slope, 0);
}

// Two patches with single rays before, between and after them.
struct PatchedProblem {
  TwoFields fields{1};
  RayProblem rays{fields, 7};
  std::vector<float> map = random_map(20, 4);
  std::vector<RayPatch> patches{{3, 20, 30, 0.5f, map}, {40, 20, 50, 1.f, map}};

  LearningStep step(float weight) const {
    LearningStep step = rays.step();
    step.patches = patches, step.patch_weight = weight;
    return step;
  }
};

double whole_loss(const PatchedProblem& problem, float weight, std::size_t field,
                  std::span<const float> moved) {
  TwoFields fields(1);
  for (std::size_t i = 0; i < moved.size(); ++i) fields.fields[field].parameters[i] += moved[i];
  const auto learner = cpu_backend(FieldPrecision::exact)->make_learner(fields.parts(), fields.shape());
  const auto learnt = (*learner)->step(problem.step(weight));
  return learnt->loss + learnt->patch_loss;
}

// Along the gradient itself, in which the single precision of the fields drowns least.
TEST(PatchLoss, LearnersGradientMatchesTheWholeLoss) {
  constexpr float kWeight = 0.2f;
  const PatchedProblem problem;
  TwoFields fields(1);
  const auto learner = cpu_backend(FieldPrecision::exact)->make_learner(fields.parts(), fields.shape());
  const auto learnt = (*learner)->step(problem.step(kWeight));
  ASSERT_TRUE(learnt.ok());
  EXPECT_GT(learnt->patch_loss, learnt->loss);  // or the test would not see it
  for (std::size_t f = 0; f < 2; ++f) {
    std::vector<float> along = fields.adam[f].first;
    const float one_minus_beta = 1 - AdamOptions().beta1;
    for (float& value : along) value /= one_minus_beta;
    const double slope = length(along), reach = 2e-3 / slope;
    for (float& value : along) value *= float(reach);
    const double above = whole_loss(problem, kWeight, f, along);
    for (float& value : along) value = -value;
    const double below = whole_loss(problem, kWeight, f, along);
    EXPECT_NEAR((above - below) / (2 * reach * slope), slope, 0.01 * slope) << f;
  }
}

TEST(PatchLoss, ZeroWeightChangesOnlyTheBlocks) {
  const PatchedProblem problem;
  TwoFields with(1), without(1);
  const auto one = cpu_backend(FieldPrecision::exact)->make_learner(with.parts(), with.shape());
  const auto other = cpu_backend(FieldPrecision::exact)->make_learner(without.parts(), without.shape());
  const auto patched = (*one)->step(problem.step(0)), plain = (*other)->step(problem.rays.step());
  EXPECT_EQ(patched->patch_loss, 0);
  EXPECT_NEAR(patched->loss, plain->loss, 1e-12);
  for (std::size_t f = 0; f < 2; ++f)
    EXPECT_LE(relative_l2(with.adam[f].first, without.adam[f].first), 1e-5) << f;
}

}  // namespace
}  // namespace likeness
