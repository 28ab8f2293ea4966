// Claims about training in bfloat16: its kernels match their plain loops, its gradients are close to the
// reference in double, and only the current parameters count.
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/field/adam.h"
#include "core/field/aligned_floats.h"
#include "core/field/evaluate.h"
#include "core/field/field_bf16.h"
#include "core/field/field_kernels.h"
#include "core/field/field_reference.h"
#include "core/field/train_fields.h"
#include "tests/core/field/random_field.h"
#include "tests/core/field/relative_l2.h"
#include "tests/core/field/tile_rows.h"

namespace likeness {
namespace {

// A network alone: `value` gives its weights, its input and the gradients of its output.
struct Network {
  std::vector<DenseLayer> layers;
  std::vector<float> parameters;
  PackedNetwork packed;
  std::vector<PartialLayer> places;
  std::size_t partial_count = 0;
  TileRows in{64}, g{64};

  Network(const std::vector<int>& widths, const std::function<float()>& value) {
    for (std::size_t l = 0; l + 1 < widths.size(); ++l) {
      DenseLayer layer{widths[l], widths[l + 1], parameters.size(), 0};
      layer.biases = layer.weights + std::size_t(layer.inputs * layer.outputs);
      for (int i = 0; i < layer.inputs * layer.outputs + layer.outputs; ++i) parameters.push_back(value());
      layers.push_back(layer);
    }
    FieldLayout layout;
    layout.density = layers;
    const PartialLayout partial = make_partial_layout(layout);
    places = partial.density, partial_count = partial.count;
    packed = pack_network(layers, parameters.data());
    for (std::size_t i = 0; i < std::size_t(widths.front()) * kTile; ++i) in.data[i] = value();
    for (std::size_t i = 0; i < std::size_t(widths.back()) * kTile; ++i) g.data[i] = value();
  }

  // `times` tiles, all of them this one.
  PlainGradients by_kernels(int times) const {
    const TileRows words(32), hidden0(32), hidden1(32), out(64), turned(64), pairs0(32), pairs1(32),
        samples(32);
    const PairRows kept{words.words(), {hidden0.words(), hidden1.words()}};
    const SlopeScratch scratch{turned.words(), {pairs0.words(), pairs1.words()}, samples.words()};
    const TileRows partial(partial_count / kTile + 1), rows(64);
    for (int k = 0; k < times; ++k) {
      network_bf16(packed, in.data, kept, std::size_t(layers.back().outputs), out.data);
      const std::uint32_t* first = network_backward_bf16(pack_transposed(layers, parameters.data()), kept,
                                                         g.data, places, partial.data, scratch);
      input_gradient_bf16(pack_transposed(layers[0], parameters.data(), 0, layers[0].inputs), first,
                          rows.data);
    }
    PlainGradients result;
    for (std::size_t l = 0; l < layers.size(); ++l) {
      std::vector<float> weights, biases;
      for (std::size_t o = 0; o < std::size_t(layers[l].outputs); ++o) {
        const float* row = partial.data + places[l].weights + o * places[l].stride;
        weights.insert(weights.end(), row, row + layers[l].inputs);
        const float* lanes = partial.data + places[l].biases + o * kPartialLanes;
        biases.push_back(std::accumulate(lanes, lanes + kPartialLanes, 0.0f));
      }
      result.weights.push_back(weights), result.biases.push_back(biases);
    }
    result.inputs.assign(rows.data, rows.data + std::size_t(layers[0].inputs) * kTile);
    return result;
  }
};

std::vector<std::vector<int>> all_widths() {
  return {{64, 64, 16},  {31, 64, 64, 3}, {1, 1, 1}, {5, 13, 7},
          {9, 6, 11, 2}, {0, 4, 1},       {33, 40},  {48, 17, 15}};
}

// Small integers are exact in bfloat16, and so are their sums in any order in single precision; sums of the
// second layer are rounded alike.
TEST(TrainBf16, NetworksBackpropagateLikeThePlainLoopsBitForBit) {
  if (!cpu_has_bf16()) GTEST_SKIP() << "this processor has no AVX-512 BF16";
  std::mt19937 random(1);
  for (const std::vector<int>& widths : all_widths()) {
    const Network network(widths, [&] { return float(int(random() % 5) - 2); });
    const PlainGradients fast = network.by_kernels(1), plain = network_backward_bf16_reference(
                                                           network.packed, network.in.data, network.g.data);
    EXPECT_EQ(fast.weights, plain.weights) << widths.size() << " layers of " << widths[1];
    EXPECT_EQ(fast.biases, plain.biases) << widths.size() << " layers of " << widths[1];
    EXPECT_EQ(fast.inputs, plain.inputs) << widths.size() << " layers of " << widths[1];
  }
}

// A sum that lies between two neighbours may be rounded otherwise in another order of additions.
TEST(TrainBf16, NetworksOfAnyNumbersBackpropagateLikeThePlainLoops) {
  if (!cpu_has_bf16()) GTEST_SKIP() << "this processor has no AVX-512 BF16";
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  for (const std::vector<int>& widths : all_widths()) {
    const Network network(widths, [&] { return normal(random); });
    const PlainGradients fast = network.by_kernels(3), plain = network_backward_bf16_reference(
                                                           network.packed, network.in.data, network.g.data);
    const double most = widths.size() == 2 ? 1e-6 : 5e-4;
    EXPECT_LE(relative_l2(fast.inputs, plain.inputs), most);
    for (std::size_t l = 0; l < fast.weights.size(); ++l) {
      std::vector<float> weights = plain.weights[l], biases = plain.biases[l];
      for (std::vector<float>* sums : {&weights, &biases})
        for (float& v : *sums) v *= 3;  // tiles
      EXPECT_LE(relative_l2(fast.weights[l], weights), most) << l << " of " << widths.size();
      EXPECT_LE(relative_l2(fast.biases[l], biases), most) << l << " of " << widths.size();
    }
  }
}

struct Passed {
  FieldOutputs out;
  FieldGradients gradients;
};

Passed pass(const Field& field, const Batch& batch, FieldTape& tape,
            FieldPrecision precision = FieldPrecision::bf16) {
  Passed p{{}, make_gradients(field, batch.views)};
  p.gradients.want_conditions = p.gradients.want_positions = true;
  train_field(field, batch.inputs(), p.out, batch.output_gradients(), tape, p.gradients, precision);
  return p;
}

class TrainInBf16 : public testing::TestWithParam<NamedConfig> {};

// Samples near a fold of a ReLU or near a border of a cell may fall on its other side.
TEST_P(TrainInBf16, GradientsAreCloseToDoublePrecision) {
  const FieldConfig& config = GetParam().config;
  if (!has_bf16(config)) GTEST_SKIP() << "not in bfloat16";
  const Field field = trained_like_field(config, 3);
  Batch batch = random_batch(config, 4000, 3, 4);
  const std::vector<double> parameters(field.parameters.begin(), field.parameters.end());
  const auto samples = reference_samples<double>(config, batch.inputs(), batch.views);
  const auto margin = reference_margin<double>(config, parameters, samples);
  std::size_t kept = 0;
  for (std::size_t n = 0; n < margin.size(); ++n) {
    if (margin[n] > 1e-2)
      ++kept;
    else
      batch.sigma[n] = batch.red[n] = batch.green[n] = batch.blue[n] = 0;
  }
  EXPECT_GT(kept, 100u);
  const auto truth = reference_forward<double>(config, parameters, samples);
  const auto slopes = reference_backward<double>(config, parameters, samples,
                                                 {{batch.sigma.begin(), batch.sigma.end()},
                                                  {batch.red.begin(), batch.red.end()},
                                                  {batch.green.begin(), batch.green.end()},
                                                  {batch.blue.begin(), batch.blue.end()}});
  const auto tape = make_tape();
  const Passed passed = pass(field, batch, *tape);
  constexpr double kMost = 2e-2;
  EXPECT_LE(relative_l2(passed.out.sigma, truth.sigma), kMost);
  EXPECT_GT(relative_l2(passed.out.sigma, truth.sigma), 1e-5);  // it is rounded indeed
  EXPECT_LE(relative_l2(passed.out.red, truth.red), kMost);
  EXPECT_LE(relative_l2(passed.out.green, truth.green), kMost);
  EXPECT_LE(relative_l2(passed.out.blue, truth.blue), kMost);
  for (const ParameterBlock& block : parameter_layout(config)) {
    const std::span<const float> own(passed.gradients.parameters.data() + block.offset, block.count);
    const std::span<const double> right(slopes.parameters.data() + block.offset, block.count);
    EXPECT_LE(relative_l2(own, right), kMost) << block.name;
  }
  EXPECT_LE(relative_l2(passed.gradients.latents, slopes.latents), kMost);
  EXPECT_LE(relative_l2(passed.gradients.conditions, slopes.conditions), kMost);
  EXPECT_LE(relative_l2(passed.gradients.x, slopes.x), kMost);
  EXPECT_LE(relative_l2(passed.gradients.y, slopes.y), kMost);
  EXPECT_LE(relative_l2(passed.gradients.z, slopes.z), kMost);
}

INSTANTIATE_TEST_SUITE_P(Configs, TrainInBf16, testing::ValuesIn(small_configs()),
                         [](const auto& info) { return info.param.name; });

FieldConfig whole_config() {
  FieldConfig config;
  config.condition_count = 6, config.latent_count = 4;
  config.position = {3, 6, 4, 11, 4, 64};
  return config;
}

TEST(TrainBf16, RepeatsBitForBitWithAnyNumberOfThreads) {
  const Field field = trained_like_field(whole_config(), 5);
  const Batch batch = random_batch(field.config, 9001, 3, 6);
  const auto tape = make_tape(), another = make_tape();
  const Passed many = pass(field, batch, *tape), again = pass(field, batch, *tape);
  const ThreadLimit one(1);
  const Passed alone = pass(field, batch, *another);
  for (const Passed* other : {&again, &alone}) {
    EXPECT_EQ(many.out.sigma, other->out.sigma);
    EXPECT_EQ(many.out.blue, other->out.blue);
    EXPECT_EQ(many.gradients.parameters, other->gradients.parameters);
    EXPECT_EQ(many.gradients.touched, other->gradients.touched);
    EXPECT_EQ(many.gradients.conditions, other->gradients.conditions);
    EXPECT_EQ(many.gradients.x, other->gradients.x);
  }
}

TEST(TrainBf16, GivesTheOutputsOfAnEvaluation) {
  Field field = trained_like_field(whole_config(), 5);
  const Batch batch = random_batch(field.config, 3000, 3, 6);
  const auto tape = make_tape();
  FieldOutputs out;
  for (const bool rounded : {false, true}) {
    if (rounded) round_tables(field);
    for (const FieldPrecision precision : {FieldPrecision::exact, FieldPrecision::bf16}) {
      const Passed passed = pass(field, batch, *tape, precision);
      evaluate_field(field, batch.inputs(), out, precision);
      EXPECT_EQ(passed.out.sigma, out.sigma);
      EXPECT_EQ(passed.out.red, out.red);
    }
  }
}

// If the parameters change between two steps, a tape keeps nothing of the older ones.
TEST(TrainBf16, DoesNotDependOnEarlierParameters) {
  Field field = trained_like_field(whole_config(), 7), other = trained_like_field(whole_config(), 8);
  const Batch batch = random_batch(field.config, 1000, 3, 9);
  const auto used = make_tape(), fresh = make_tape();
  pass(field, batch, *used);
  round_tables(field);  // training never reads what pictures have rounded
  field.parameters = other.parameters;
  const Passed after = pass(field, batch, *used), right = pass(other, batch, *fresh);
  EXPECT_EQ(after.out.sigma, right.out.sigma);
  EXPECT_EQ(after.gradients.parameters, right.gradients.parameters);
}

// Both precisions learn a ball that moves with the condition, equally well.
TEST(TrainBf16, LearnsAsSinglePrecisionDoes) {
  FieldConfig config;
  config.position = {3, 4, 4, 12, 4, 32};
  config.ambient_grid = {2, 4, 4, 10, 4, 16};
  config.condition_count = 1;
  config.density_width = config.colour_width = 32;
  constexpr std::size_t kCount = 2048;
  const auto learn = [&](FieldPrecision precision, std::uint32_t seed) {
    Field field = make_field(config, seed);
    const auto tape = make_tape();
    FieldGradients gradients = make_gradients(field, 16);
    AdamState state = make_adam_state(field);
    double loss = 0;
    for (std::uint32_t i = 0; i < 80; ++i) {
      Batch batch = random_batch(config, kCount, 16, 1000 * seed + i);
      for (std::size_t v = 0; v < 16; ++v) batch.conditions[v] = float(v) / 15;
      FieldOutputs out;
      const auto compare = [&](std::size_t) {
        for (std::size_t n = 0; n < kCount; ++n) {
          const float centre = 0.3f + 0.4f * batch.conditions[std::size_t(batch.view[n])];
          const bool inside = std::hypot(batch.x[n] - centre, batch.y[n] - 0.5f, batch.z[n] - 0.5f) < 0.2f;
          const float alpha = 1 - std::exp(-out.sigma[n] / 20), miss = alpha - float(inside);
          const float off = inside ? out.red[n] - batch.y[n] : 0.0f;
          batch.sigma[n] = 2 * miss * (1 - alpha) / 20 / kCount;
          batch.red[n] = 2 * off / kCount;
          batch.green[n] = batch.blue[n] = 0;
          if (i >= 60) loss += (miss * miss + off * off) / kCount / 20;
        }
      };
      const std::size_t end = kCount;
      const FieldStep step{field, batch.inputs(), {&end, 1}, out, batch.output_gradients(),
                           *tape, gradients,      precision};
      train_fields({&step, 1}, compare);
      adam_step(field, gradients, state, {});
    }
    return loss;
  };
  double single = 0, rounded = 0;
  for (const std::uint32_t seed : {1u, 2u}) {
    single += learn(FieldPrecision::exact, seed) / 2;
    rounded += learn(FieldPrecision::bf16, seed) / 2;
  }
  RecordProperty("single", std::to_string(single));
  RecordProperty("bf16", std::to_string(rounded));
  // Another compiler's order of sums alone moves either by some per cent.
  EXPECT_LT(rounded, 1.15 * single);
  EXPECT_GT(rounded, 0.85 * single);
}

}  // namespace
}  // namespace likeness
