// Claims about core/field/conditioned_field.h and field_bf16.h: folding psi into the biases changes nothing,
// bfloat16 little, and its kernels match their plain loops.
#include "core/field/conditioned_field.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/field/aligned_floats.h"
#include "core/field/evaluate.h"
#include "core/field/field_bf16.h"
#include "core/field/field_kernels.h"
#include "core/field/field_reference.h"
#include "tests/core/field/random_field.h"
#include "tests/core/field/relative_l2.h"
#include "tests/core/field/tile_rows.h"

namespace likeness {
namespace {

// One view without a latent code.
Batch picture_batch(const FieldConfig& config, std::size_t count, std::uint32_t seed) {
  Batch batch = random_batch(config, count, 1, seed);
  batch.latents.assign(batch.latents.size(), 0.0f);
  return batch;
}

struct Picture {
  std::vector<float> sigma;
  FieldOutputs colours;  // of `chosen`
  std::vector<std::uint32_t> chosen;
};

Picture evaluate_picture(const Field& field, const Batch& batch, FieldPrecision precision) {
  const ConditionedField conditioned(field, batch.conditions, precision);
  Picture out;
  for (std::uint32_t n = 0; n < batch.x.size(); n += 1 + n % 3) out.chosen.push_back(n);
  GeometryFeatures geometry;
  evaluate_density(conditioned, batch.inputs(), out.sigma, geometry);
  evaluate_colour(conditioned, batch.inputs(), geometry, out.chosen, out.colours);
  std::vector<float> alone;
  evaluate_density(conditioned, batch.inputs(), alone);
  EXPECT_EQ(alone, out.sigma);
  return out;
}

void expect_near_reference(const Field& field, const Batch& batch, FieldPrecision precision, double most) {
  const std::vector<double> parameters(field.parameters.begin(), field.parameters.end());
  const auto samples = reference_samples<double>(field.config, batch.inputs(), 1);
  const auto truth = reference_forward<double>(field.config, parameters, samples);
  const Picture out = evaluate_picture(field, batch, precision);
  EXPECT_LE(relative_l2(out.sigma, truth.sigma), most);
  const auto chosen = [&](const std::vector<double>& all) {
    std::vector<double> some;
    for (const std::uint32_t n : out.chosen) some.push_back(all[n]);
    return some;
  };
  EXPECT_LE(relative_l2(out.colours.red, chosen(truth.red)), most);
  EXPECT_LE(relative_l2(out.colours.green, chosen(truth.green)), most);
  EXPECT_LE(relative_l2(out.colours.blue, chosen(truth.blue)), most);
}

class Conditioned : public testing::TestWithParam<NamedConfig> {};

TEST_P(Conditioned, MatchesTheFieldUnderItsCondition) {
  const Field field = trained_like_field(GetParam().config, 3);
  expect_near_reference(field, picture_batch(field.config, 333, 4), FieldPrecision::exact, 1e-5);
}

TEST_P(Conditioned, InBf16IsWithinThreeThousandths) {
  const Field field = trained_like_field(GetParam().config, 3);
  expect_near_reference(field, picture_batch(field.config, 333, 4), FieldPrecision::bf16, 6e-3);
}

INSTANTIATE_TEST_SUITE_P(Configs, Conditioned, testing::ValuesIn(small_configs()),
                         [](const auto& info) { return info.param.name; });

FieldConfig picture_config() {
  FieldConfig config;
  config.condition_count = 6;
  config.latent_count = 4;
  config.density_layers = 1;
  return config;
}

TEST(ConditionedFull, RepeatsBitForBitWithAnyNumberOfThreads) {
  const Field field = trained_like_field(picture_config(), 5);
  const Batch batch = picture_batch(field.config, 5000, 6);
  for (const FieldPrecision precision : {FieldPrecision::exact, FieldPrecision::bf16}) {
    const Picture many = evaluate_picture(field, batch, precision);
    const ThreadLimit one(1);
    const Picture alone = evaluate_picture(field, batch, precision);
    EXPECT_EQ(many.sigma, alone.sigma);
    EXPECT_EQ(many.colours.red, alone.colours.red);
  }
}

TEST(ConditionedFull, ASampleDoesNotDependOnItsBatch) {
  const Field field = trained_like_field(picture_config(), 7);
  const Batch batch = picture_batch(field.config, 700, 8);
  for (const FieldPrecision precision : {FieldPrecision::exact, FieldPrecision::bf16}) {
    const ConditionedField conditioned(field, batch.conditions, precision);
    std::vector<float> whole, part;
    evaluate_density(conditioned, batch.inputs(), whole);
    for (const std::size_t count : {0, 1, 31, 33, 64, 65}) {
      FieldInputs some = batch.inputs();
      some.count = count;
      evaluate_density(conditioned, some, part);
      ASSERT_EQ(part.size(), count);
      for (std::size_t n = 0; n < count; ++n) EXPECT_EQ(part[n], whole[n]);
    }
  }
}

TEST(ConditionedFull, HugeWeightsAndPositionsThatAreNotNumbersStayInBounds) {
  Field field = trained_like_field(picture_config(), 9);
  Batch batch = picture_batch(field.config, 100, 10);
  for (float& p : field.parameters) p *= 1e4f;
  batch.x[7] = std::numeric_limits<float>::quiet_NaN(), batch.y[8] = -3, batch.z[9] = 1e30f;
  for (const float v : evaluate_picture(field, batch, FieldPrecision::bf16).sigma) EXPECT_GE(v, 0);
}

TEST(ConditionedFull, TablesRoundedBeforehandAreTheSame) {
  Field field = trained_like_field(picture_config(), 5);
  const Batch batch = picture_batch(field.config, 500, 6);
  const Picture anew = evaluate_picture(field, batch, FieldPrecision::bf16);
  round_tables(field);
  EXPECT_EQ(field.rounded != nullptr, has_bf16(field.config));
  EXPECT_EQ(evaluate_picture(field, batch, FieldPrecision::bf16).sigma, anew.sigma);
}

// A condition that acts in a region moves nothing outside it, to the bit, and something inside; one that is 0
// everywhere costs nothing.
TEST(ConditionedFull, ConditionOfARegionActsOnlyThere) {
  for (const bool ambient : {true, false}) {
    FieldConfig config = picture_config();
    config.ambient = ambient, config.local_conditions = 2;
    const Field field = trained_like_field(config, 15);
    Batch batch = picture_batch(config, 400, 16);
    for (std::size_t n = 0; n < 400; ++n) batch.local[n] = n < 200 ? 0.f : 0.75f, batch.local[400 + n] = 0;
    batch.conditions[4] = batch.conditions[5] = 0;
    Batch without = batch;
    without.local.clear();
    for (const FieldPrecision precision : {FieldPrecision::exact, FieldPrecision::bf16}) {
      EXPECT_FALSE(ConditionedField(field, batch.conditions, precision).needs_local());
      const Picture rest = evaluate_picture(field, without, precision);
      Batch moved = batch;
      moved.conditions[4] = 0.8f;
      EXPECT_TRUE(ConditionedField(field, moved.conditions, precision).needs_local());
      const Picture more = evaluate_picture(field, moved, precision);
      moved.conditions[4] = 0.4f;
      const Picture less = evaluate_picture(field, moved, precision);
      for (std::size_t n = 0; n < 400; ++n) {
        if (n < 200) {
          ASSERT_EQ(more.sigma[n], less.sigma[n]) << n;
          // Another order of sums than without the columns, and no more.
          ASSERT_NEAR(more.sigma[n], rest.sigma[n], 1e-2f * rest.sigma[n] + 1e-4f) << n;
        } else {
          ASSERT_NE(more.sigma[n], rest.sigma[n]) << n;
        }
      }
      for (std::size_t i = 0; i < rest.chosen.size(); ++i)
        if (rest.chosen[i] < 200) {
          ASSERT_EQ(more.colours.red[i], less.colours.red[i]) << i;
        }
    }
  }
}

TEST(Bf16, RoundsToTheNearestTiesToEven) {
  EXPECT_EQ(from_bf16(to_bf16(1.0f)), 1.0f);
  EXPECT_EQ(from_bf16(to_bf16(1.0f + 0x1p-8f)), 1.0f);              // a tie
  EXPECT_EQ(from_bf16(to_bf16(1.0f + 0x1.8p-7f)), 1.0f + 0x1p-6f);  // a tie
  EXPECT_EQ(from_bf16(to_bf16(-1.0f - 0x1.01p-8f)), -1.0f - 0x1p-7f);
  EXPECT_TRUE(std::isnan(from_bf16(to_bf16(std::numeric_limits<float>::quiet_NaN()))));
  EXPECT_TRUE(std::isinf(from_bf16(to_bf16(std::numeric_limits<float>::max()))));
  if (!cpu_has_bf16()) GTEST_SKIP() << "this processor has no AVX-512 BF16";
  std::mt19937 random(1);
  std::normal_distribution<float> value;
  std::vector<float> from(75);
  for (float& v : from) v = value(random);
  std::vector<std::uint16_t> to(from.size());
  round_table(from.data(), from.size(), to.data());
  for (std::size_t i = 0; i < from.size(); ++i) EXPECT_EQ(to[i], to_bf16(from[i]));
}

TEST(Bf16, LooksUpLikeThePlainLoops) {
  if (!cpu_has_bf16()) GTEST_SKIP() << "this processor has no AVX-512 BF16";
  for (const NamedConfig& named : small_configs()) {
    if (!grid_has_bf16(named.config.position)) continue;
    const Field field = trained_like_field(named.config, 11);
    const FieldLayout layout = make_layout(field.config);
    std::vector<std::uint16_t> tables(layout.table_count);
    round_table(field.parameters.data(), tables.size(), tables.data());
    const Batch batch = random_batch(field.config, kTile, 1, 12);
    const float* point[3] = {batch.x.data(), batch.y.data(), batch.z.data()};
    const auto expect_same = [&](const GridLevel& level, const GridConfig& grid) {
      const auto width = std::size_t(grid.features);
      TileRows fast(width), plain(width);
      encode_tile_bf16(level, grid, tables.data(), point, fast.data);
      encode_tile_bf16_reference(level, grid, tables.data(), point, plain.data);
      EXPECT_LE(relative_l2(std::span(fast.data, width * kTile), std::span(plain.data, width * kTile)), 5e-4)
          << named.name;
    };
    for (const GridLevel& level : layout.position) expect_same(level, field.config.position);
    for (const GridLevel& level : layout.ambient) expect_same(level, field.config.ambient_grid);
  }
}

TEST(Bf16, NetworksOfAnyWidthMatchThePlainLoops) {
  if (!cpu_has_bf16()) GTEST_SKIP() << "this processor has no AVX-512 BF16";
  std::mt19937 random(13);
  std::normal_distribution<float> value;
  for (const std::vector<int>& widths : {std::vector{64, 64, 16},
                                         {28, 64, 64, 3},
                                         {1, 1, 1},
                                         {5, 13, 7},
                                         {9, 6, 11, 2},
                                         {0, 4, 1},
                                         {33, 40}}) {
    std::vector<DenseLayer> layers;
    std::vector<float> parameters;
    for (std::size_t l = 0; l + 1 < widths.size(); ++l) {
      DenseLayer layer{widths[l], widths[l + 1], parameters.size(), 0};
      layer.biases = layer.weights + std::size_t(layer.inputs * layer.outputs);
      for (int i = 0; i < layer.inputs * layer.outputs + layer.outputs; ++i)
        parameters.push_back(value(random));
      layers.push_back(layer);
    }
    const PackedNetwork network = pack_network(layers, parameters.data());
    TileRows in(64), scratch(64), hidden0(64), hidden1(64), fast(64), plain(64);
    for (std::size_t i = 0; i < std::size_t(widths[0]) * kTile; ++i) in.data[i] = value(random);
    for (std::size_t outputs = 1; outputs <= std::size_t(widths.back()); outputs += 1 + outputs / 2) {
      network_bf16(network, in.data, {scratch.words(), {hidden0.words(), hidden1.words()}}, outputs,
                   fast.data);
      network_bf16_reference(network, in.data, outputs, plain.data);
      EXPECT_LE(relative_l2(std::span(fast.data, outputs * kTile), std::span(plain.data, outputs * kTile)),
                5e-4)
          << widths.size() << " layers of " << widths[1];
    }
  }
}

}  // namespace
}  // namespace likeness
