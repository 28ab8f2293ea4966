// Claims about core/render/backend.h: a device learns what the processor learns, waits once per step, and
// fails cleanly. The same claims are made of the emulated device and, labelled gpu, of a CUDA one.
#include "core/render/backend.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/field/field_reference.h"
#include "tests/core/device/emulated_device.h"
#include "tests/core/render/two_fields.h"

namespace likeness {
namespace {

class BackendTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string why;
    device_ = tested_device(why);
    if (!device_) GTEST_SKIP() << why;
  }
  static std::unique_ptr<FieldLearner> learner(Backend& backend, TwoFields& fields) {
    auto made = backend.make_learner(fields.parts(), fields.shape());
    EXPECT_TRUE(made.ok()) << made.error().what;
    return std::move(*made);
  }
  std::shared_ptr<Device> device_;
};

TEST_F(BackendTest, StepMatchesTheProcessor) {
  TwoFields here(1), there(1);
  const auto cpu = learner(*cpu_backend(FieldPrecision::exact), here),
             device = learner(*device_backend(device_, false), there);
  const TwoFields start(1);
  const RayProblem problem(here, 7);
  const auto one = cpu->step(problem.step()), other = device->step(problem.step());
  ASSERT_TRUE(one.ok() && other.ok());
  EXPECT_NEAR(other->loss, one->loss, 1e-6 * one->loss);
  ASSERT_TRUE(device->fetch().ok());
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_LE(relative_l2(there.adam[f].first, here.adam[f].first), 1e-5) << f;
    EXPECT_EQ(there.adam[f].line_steps, here.adam[f].line_steps) << f;
    EXPECT_EQ(there.adam[f].step, 1u);
    // Where a gradient is all but zero its sign is chance, and Adam's first step as long as any.
    const double size = std::sqrt(double(here.fields[f].parameters.size()));
    std::vector<float> moved(here.fields[f].parameters.size()), apart = moved;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      moved[i] = here.fields[f].parameters[i] - start.fields[f].parameters[i];
      apart[i] = there.fields[f].parameters[i] - here.fields[f].parameters[i];
    }
    EXPECT_GT(length(moved), 1e-4 * size);
    EXPECT_LE(length(apart), 2e-2 * length(moved)) << f;
  }
  EXPECT_LE(relative_l2(there.codes_adam.first, here.codes_adam.first), 1e-5);
  EXPECT_EQ(there.codes_adam.step, 1u);
  EXPECT_LE(relative_l2(there.codes, here.codes), 1e-3);
}

TEST_F(BackendTest, LossFallsAsOnTheProcessor) {
  for (const bool halves : {false, true}) {
    TwoFields here(2), there(2);
    const auto cpu = learner(*cpu_backend(FieldPrecision::exact), here),
               device = learner(*device_backend(device_, halves), there);
    double first = 0, one = 0, other = 0;
    for (int k = 0; k < 24; ++k) {
      const RayProblem problem(here, 11);
      one = cpu->step(problem.step())->loss, other = device->step(problem.step())->loss;
      if (k == 0) first = one;
    }
    EXPECT_LT(one, 0.75 * first);
    EXPECT_NEAR(other, one, 0.1 * one) << halves;
  }
}

TEST_F(BackendTest, EitherBackendContinuesWhatTheOtherLearnt) {
  TwoFields uncut(3), moved(3);
  const auto all = learner(*cpu_backend(FieldPrecision::exact), uncut);
  auto part = learner(*cpu_backend(FieldPrecision::exact), moved);
  std::vector<double> losses[2];
  for (int k = 0; k < 12; ++k) {
    const RayProblem problem(uncut, 13);
    if (k == 4 || k == 8) {
      ASSERT_TRUE(part->fetch().ok());
      part = learner(k == 4 ? *device_backend(device_, false) : *cpu_backend(FieldPrecision::exact), moved);
    }
    losses[0].push_back(all->step(problem.step())->loss);
    losses[1].push_back(part->step(problem.step())->loss);
  }
  for (std::size_t k = 0; k < 12; ++k) EXPECT_NEAR(losses[1][k], losses[0][k], 0.02 * losses[0][k]) << k;
  EXPECT_EQ(moved.adam[0].step, uncut.adam[0].step);
}

TEST_F(BackendTest, DensitiesMatchTheProcessorForAnyNumberOfSamples) {
  TwoFields here(4), there(4);
  const auto cpu = learner(*cpu_backend(FieldPrecision::exact), here),
             device = learner(*device_backend(device_, false), there);
  for (const std::size_t count : {std::size_t{1}, std::size_t{1500}}) {
    const Batch batch = random_batch(here.fields[0].config, count, 2 * TwoFields::kViews, 5);
    std::vector<float> one, other;
    ASSERT_TRUE(cpu->densities(0, batch.inputs(), one).ok());
    ASSERT_TRUE(device->densities(0, batch.inputs(), other).ok());
    EXPECT_LE(relative_l2(other, one), 1e-5);
  }
}

TEST_F(BackendTest, ALossThatIsNotFiniteChangesNothing) {
  TwoFields there(5);
  const TwoFields start(5);
  const auto device = learner(*device_backend(device_), there);
  RayProblem problem(there, 17);
  problem.target[3].x() = NAN;
  const auto result = device->step(problem.step());
  ASSERT_TRUE(result.ok());
  EXPECT_FALSE(std::isfinite(result->loss));
  ASSERT_TRUE(device->fetch().ok());
  for (std::size_t f = 0; f < 2; ++f) EXPECT_EQ(there.fields[f].parameters, start.fields[f].parameters);
  EXPECT_EQ(there.adam[0].step, 0u);
  EXPECT_EQ(there.codes, start.codes);
  problem.target[3].x() = 0.5f;
  EXPECT_TRUE(std::isfinite(device->step(problem.step())->loss));  // and the next step is a step again
}

}  // namespace
}  // namespace likeness
