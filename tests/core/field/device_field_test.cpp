// Claims about core/field/device_field.h and the arithmetic of its kernels: outputs, gradients and Adam match
// the reference in double. The same claims are made of the emulated device and, labelled gpu, of a CUDA one.
#include "core/field/device_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/field/evaluate.h"
#include "core/field/field_reference.h"
#include "core/field/train_fields.h"
#include "tests/core/device/emulated_device.h"
#include "tests/core/field/random_field.h"
#include "tests/core/field/relative_l2.h"

namespace likeness {
namespace {

constexpr double kSingleError = 1e-5, kHalfError = 2e-2;
constexpr std::size_t kSamples = 201, kViews = 5;  // no multiple of a tile
// A GPU gets more tiles than an H100 has blocks, so that blocks loop.
std::size_t many_samples() { return tests_cuda() ? 36001 : 601; }

struct Passed {
  FieldOutputs out;
  std::vector<float> gradients, d_codes;
};

struct Case {
  NamedConfig named;
  NetworkPrecision precision;
  std::size_t samples = kSamples;
  // Of tables and conditions. The effect of rounding at the folds of many units grows with it.
  float scale = 1;
};

std::vector<float> fetched(Device& device, const float* from, std::size_t count) {
  std::vector<float> values(count);
  EXPECT_TRUE(device.copy_out(values.data(), from, count * sizeof(float)).ok());
  EXPECT_TRUE(device.wait().ok());
  return values;
}

std::vector<float> ones_of(const std::vector<float>& values, std::size_t capacity, std::size_t row,
                           std::size_t n) {
  return {values.begin() + std::ptrdiff_t(row * capacity),
          values.begin() + std::ptrdiff_t(row * capacity + n)};
}

class DeviceFieldTest : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    std::string why;
    device_ = tested_device(why);
    if (!device_) GTEST_SKIP() << why;
  }

  std::unique_ptr<DeviceField> make(const Field& field, std::size_t capacity) const {
    DeviceFieldOptions options{capacity, kViews, true, GetParam().precision};
    auto made = DeviceField::make(device_, field.config, options);
    EXPECT_TRUE(made.ok()) << made.error().what;
    const AdamState adam = make_adam_state(field);
    EXPECT_TRUE((*made)->place(field, &adam).ok());
    EXPECT_TRUE(device_->wait().ok());
    return std::move(*made);
  }

  static void fill(DeviceField& on, const Batch& batch) {
    EXPECT_TRUE(on.set_samples(batch.inputs()).ok());
    EXPECT_TRUE(on.set_conditions(batch.conditions.data(), batch.conditions.empty() ? 0 : kViews).ok());
    EXPECT_TRUE(on.set_codes(batch.latents.empty() ? nullptr : batch.latents.data(), kViews).ok());
    EXPECT_TRUE(on.set_count(std::uint32_t(batch.x.size())).ok());
  }

  Passed pass(const Field& field, const Batch& batch) const {
    const std::size_t n = batch.x.size(), capacity = (n + 255) / 256 * 256;
    auto on = make(field, capacity);
    fill(*on, batch);
    EXPECT_TRUE(on->density().ok() && on->colour().ok());
    const float* slopes[4] = {batch.sigma.data(), batch.red.data(), batch.green.data(), batch.blue.data()};
    for (std::size_t k = 0; k < 4; ++k) {
      float* to = k == 0 ? on->d_sigma() : on->d_colours() + (k - 1) * capacity;
      EXPECT_TRUE(device_->copy_in(to, slopes[k], n * sizeof(float)).ok());
    }
    EXPECT_TRUE(on->backward().ok());
    Passed passed;
    const auto colours = fetched(*device_, on->colours(), 3 * capacity);
    passed.out = {fetched(*device_, on->sigma(), n), ones_of(colours, capacity, 0, n),
                  ones_of(colours, capacity, 1, n), ones_of(colours, capacity, 2, n)};
    passed.gradients = fetched(*device_, on->gradients(), field.parameters.size());
    if (!batch.latents.empty()) passed.d_codes = fetched(*device_, on->d_codes(), batch.latents.size());
    return passed;
  }
  double allowed() const {
    return GetParam().precision == NetworkPrecision::single ? kSingleError : kHalfError;
  }
  std::shared_ptr<Device> device_;
};

// A sample within rounding of a place without derivative has no gradient to compare.
Batch settled(const FieldConfig& config, const Field& field, Batch batch, double margin_least) {
  const std::vector<double> parameters(field.parameters.begin(), field.parameters.end());
  const auto samples = reference_samples<double>(config, batch.inputs(), batch.views);
  const auto margin = reference_margin<double>(config, parameters, samples);
  for (std::size_t n = 0; n < margin.size(); ++n)
    if (margin[n] < margin_least) batch.sigma[n] = batch.red[n] = batch.green[n] = batch.blue[n] = 0;
  return batch;
}

TEST_P(DeviceFieldTest, OutputsAndGradientsMatchTheReference) {
  const FieldConfig& config = GetParam().named.config;
  const Field field = trained_like_field(config, 3, 0.5f * GetParam().scale);
  const bool single = GetParam().precision == NetworkPrecision::single;
  Batch drawn = random_batch(config, GetParam().samples, kViews, 9);
  for (float& condition : drawn.conditions) condition *= GetParam().scale;
  const Batch batch = settled(config, field, std::move(drawn), single ? 1e-4 : 4e-3);
  const std::vector<double> parameters(field.parameters.begin(), field.parameters.end());
  const auto samples = reference_samples<double>(config, batch.inputs(), batch.views);
  const auto truth = reference_forward<double>(config, parameters, samples);
  const auto slopes = reference_backward<double>(config, parameters, samples,
                                                 {{batch.sigma.begin(), batch.sigma.end()},
                                                  {batch.red.begin(), batch.red.end()},
                                                  {batch.green.begin(), batch.green.end()},
                                                  {batch.blue.begin(), batch.blue.end()}});
  const Passed passed = pass(field, batch);
  EXPECT_LE(relative_l2(passed.out.sigma, truth.sigma), allowed());
  if (!single) {
    EXPECT_GT(relative_l2(passed.out.sigma, truth.sigma), kSingleError);  // it is rounded indeed
  }
  EXPECT_LE(relative_l2(passed.out.red, truth.red), allowed());
  EXPECT_LE(relative_l2(passed.out.green, truth.green), allowed());
  EXPECT_LE(relative_l2(passed.out.blue, truth.blue), allowed());
  for (const ParameterBlock& block : parameter_layout(config)) {
    const std::span<const float> own(passed.gradients.data() + block.offset, block.count);
    const std::span<const double> right(slopes.parameters.data() + block.offset, block.count);
    EXPECT_LE(relative_l2(own, right), allowed()) << block.name;
  }
  if (!passed.d_codes.empty()) {
    EXPECT_LE(relative_l2(passed.d_codes, slopes.latents), allowed());
  }
}

// One step of both: the host's after its own gradients.
TEST_P(DeviceFieldTest, AdamStepMatchesTheProcessor) {
  const FieldConfig& config = GetParam().named.config;
  Field field = trained_like_field(config, 3);
  const Batch batch = settled(config, field, random_batch(config, kSamples, kViews, 9), 1e-4);
  auto on = make(field, 256);
  // The host's gradients, given to both.
  FieldGradients gradients = make_gradients(field, kViews);
  const auto tape = make_tape();
  FieldOutputs out;
  train_field(field, batch.inputs(), out, batch.output_gradients(), *tape, gradients, FieldPrecision::exact);
  fill(*on, batch);
  EXPECT_TRUE(
      device_->copy_in(on->gradients(), gradients.parameters.data(), 4 * gradients.parameters.size()).ok());
  AdamState adam = make_adam_state(field);
  AdamOptions options;
  options.table_rate = 3e-2f, options.network_rate = 1e-2f, options.table_decay = 0.2f;
  const StepNumbers numbers{{std::uint32_t(kSamples), 0},
                            1,
                            1,
                            options.table_rate,
                            1 - options.table_decay * options.table_rate,
                            {options.network_rate * adam_corrections(options, 2)[1], 0},
                            0};
  const StepSums sums{1};
  auto device_numbers = DeviceArray<StepNumbers>::make(device_, 1);
  auto device_sums = DeviceArray<StepSums>::make(device_, 1);
  ASSERT_TRUE(device_numbers.ok() && device_sums.ok());
  EXPECT_TRUE(device_->copy_in(device_numbers->data(), &numbers, sizeof(numbers)).ok());
  EXPECT_TRUE(device_->copy_in(device_sums->data(), &sums, sizeof(sums)).ok());
  EXPECT_TRUE(on->step_tables(device_numbers->data(), device_sums->data()).ok());
  EXPECT_TRUE(on->step_networks(device_numbers->data(), device_sums->data(), 0).ok());
  const std::vector<float> before = field.parameters;
  adam_step(field, gradients, adam, options);
  Field moved = field;
  AdamState moments = adam;
  EXPECT_TRUE(on->fetch(moved, &moments).ok());
  EXPECT_TRUE(device_->wait().ok());
  std::vector<float> change(before.size());
  std::vector<double> right(before.size());
  for (std::size_t i = 0; i < before.size(); ++i)
    change[i] = moved.parameters[i] - before[i], right[i] = double(field.parameters[i]) - double(before[i]);
  EXPECT_LE(relative_l2(change, right), 1e-5);
  EXPECT_LE(relative_l2(moments.first, adam.first), 1e-6);
  EXPECT_LE(relative_l2(moments.second, adam.second), 1e-6);
  EXPECT_EQ(moments.line_steps, adam.line_steps);
  for (const float g : fetched(*device_, on->gradients(), before.size())) ASSERT_EQ(g, 0.0f);
}

TEST_P(DeviceFieldTest, StepWithANonFiniteLossChangesNothing) {
  const Field field = trained_like_field(GetParam().named.config, 3);
  auto on = make(field, 256);
  const Batch batch = random_batch(field.config, 64, kViews, 9);
  fill(*on, batch);
  const std::vector<float> gradients(field.parameters.size(), NAN);
  EXPECT_TRUE(device_->copy_in(on->gradients(), gradients.data(), 4 * gradients.size()).ok());
  const StepNumbers numbers{{64, 0}, 1, 1, 1, 0.5f, {1, 0}, 0};
  const StepSums sums{INFINITY};
  auto device_numbers = DeviceArray<StepNumbers>::make(device_, 1);
  auto device_sums = DeviceArray<StepSums>::make(device_, 1);
  ASSERT_TRUE(device_numbers.ok() && device_sums.ok());
  EXPECT_TRUE(device_->copy_in(device_numbers->data(), &numbers, sizeof(numbers)).ok());
  EXPECT_TRUE(device_->copy_in(device_sums->data(), &sums, sizeof(sums)).ok());
  EXPECT_TRUE(on->step_tables(device_numbers->data(), device_sums->data()).ok());
  EXPECT_TRUE(on->step_networks(device_numbers->data(), device_sums->data(), 0).ok());
  Field after = field;
  AdamState adam = make_adam_state(field);
  EXPECT_TRUE(on->fetch(after, &adam).ok());
  EXPECT_TRUE(device_->wait().ok());
  EXPECT_EQ(after.parameters, field.parameters);
  EXPECT_EQ(adam.line_steps, make_adam_state(field).line_steps);
  for (const float g : fetched(*device_, on->gradients(), gradients.size())) ASSERT_EQ(g, 0.0f);
}

TEST_P(DeviceFieldTest, AnEmptyBatchAddsNothing) {
  const FieldConfig& config = GetParam().named.config;
  const Field field = trained_like_field(config, 3);
  auto on = make(field, 256);
  const Batch batch = random_batch(config, 64, kViews, 9);
  fill(*on, batch);
  EXPECT_TRUE(on->set_count(0).ok());
  EXPECT_TRUE(on->density().ok() && on->colour().ok() && on->backward().ok());
  for (const float g : fetched(*device_, on->gradients(), field.parameters.size())) ASSERT_EQ(g, 0.0f);
  if (batch.latents.empty()) return;
  for (const float g : fetched(*device_, on->d_codes(), batch.latents.size())) ASSERT_EQ(g, 0.0f);
}

// The same numbers whether a block has one thread or several: no thread reads what another is still writing.
// Built with the thread sanitizer, this also finds races of the device code.
TEST_P(DeviceFieldTest, ThreadsOfABlockMatchASingleThread) {
  if (tests_cuda()) GTEST_SKIP() << "of the emulated device";
  const FieldConfig& config = GetParam().named.config;
  const Field field = trained_like_field(config, 3);
  const Batch batch = random_batch(config, kSamples, kViews, 9);
  const Passed alone = pass(field, batch);
  device_ = emulated_device({.threads = true});
  const Passed together = pass(field, batch);
  EXPECT_EQ(together.out.sigma, alone.out.sigma);
  EXPECT_EQ(together.out.green, alone.out.green);
  EXPECT_EQ(together.gradients, alone.gradients);
  EXPECT_EQ(together.d_codes, alone.d_codes);
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const NamedConfig& named : small_configs(false))
    for (const NetworkPrecision precision : {NetworkPrecision::single, NetworkPrecision::bf16})
      all.push_back({named, precision});
  // Networks as used in training, and ones too wide or too deep for the matrix units.
  FieldConfig usual;
  usual.position = {3, 4, 4, 10, 4, 24}, usual.ambient_grid = {2, 3, 4, 9, 4, 12};
  usual.condition_count = 18, usual.latent_count = 8;
  all.push_back({{"Usual", usual}, NetworkPrecision::bf16, many_samples(), 0.2f});
  FieldConfig wide = usual;
  wide.density_width = 80, wide.colour_width = 80, wide.latent_count = 20, wide.slice_width = 72;
  all.push_back({{"Wide", wide}, NetworkPrecision::bf16, kSamples, 0.2f});
  FieldConfig long_input = usual;
  long_input.ambient = false, long_input.condition_count = 90;
  all.push_back({{"LongInput", long_input}, NetworkPrecision::bf16, kSamples, 0.2f});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Configs, DeviceFieldTest, testing::ValuesIn(cases()), [](const auto& info) {
  return info.param.named.name + (info.param.precision == NetworkPrecision::single ? "Single" : "Bf16");
});

}  // namespace
}  // namespace likeness
