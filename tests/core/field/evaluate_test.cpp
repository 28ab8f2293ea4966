// Claims about core/field/evaluate.h: the fast path matches the reference on every instruction set of this
// processor, with the same bits for any number of threads.
#include "core/field/evaluate.h"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "core/base/parallel.h"
#include "core/field/field_reference.h"
#include "core/field/train_fields.h"
#include "tests/core/field/random_field.h"
#include "tests/core/field/relative_l2.h"

namespace likeness {
namespace {

struct Trained {
  FieldOutputs out;
  FieldGradients gradients;
};

Trained run(const Field& field, const Batch& batch) {
  Trained t{{}, make_gradients(field, batch.views)};
  t.gradients.want_conditions = t.gradients.want_positions = true;
  const std::shared_ptr<FieldTape> tape = make_tape();
  train_field(field, batch.inputs(), t.out, batch.output_gradients(), *tape, t.gradients,
              FieldPrecision::exact);
  return t;
}

ReferenceOutputs<double> loss_weights(const Batch& b) {
  return {{b.sigma.begin(), b.sigma.end()},
          {b.red.begin(), b.red.end()},
          {b.green.begin(), b.green.end()},
          {b.blue.begin(), b.blue.end()}};
}

void expect_parity(const Field& field, Batch batch) {
  const std::vector<double> parameters(field.parameters.begin(), field.parameters.end());
  const auto samples = reference_samples<double>(field.config, batch.inputs(), batch.views);
  const auto out = reference_forward<double>(field.config, parameters, samples);
  const auto margin = reference_margin<double>(field.config, parameters, samples);
  std::size_t left_out = 0;
  for (std::size_t n = 0; n < margin.size(); ++n) {
    if (margin[n] > 1e-4) continue;
    batch.sigma[n] = batch.red[n] = batch.green[n] = batch.blue[n] = 0;
    ++left_out;
  }
  EXPECT_LT(left_out, margin.size() / 5);
  const auto g = reference_backward<double>(field.config, parameters, samples, loss_weights(batch));
  const Trained fast = run(field, batch);
  EXPECT_LE(relative_l2(fast.out.sigma, out.sigma), 1e-5);
  EXPECT_LE(relative_l2(fast.out.red, out.red), 1e-5);
  EXPECT_LE(relative_l2(fast.out.green, out.green), 1e-5);
  EXPECT_LE(relative_l2(fast.out.blue, out.blue), 1e-5);
  for (const ParameterBlock& block : parameter_layout(field.config)) {
    const std::span<const float> f(fast.gradients.parameters.data() + block.offset, block.count);
    const std::span<const double> r(g.parameters.data() + block.offset, block.count);
    EXPECT_LE(relative_l2(f, r), 1e-4) << block.name;
  }
  EXPECT_LE(relative_l2(fast.gradients.latents, g.latents), 1e-4);
  EXPECT_LE(relative_l2(fast.gradients.conditions, g.conditions), 1e-4);
  EXPECT_LE(relative_l2(fast.gradients.x, g.x), 1e-4);
  EXPECT_LE(relative_l2(fast.gradients.y, g.y), 1e-4);
  EXPECT_LE(relative_l2(fast.gradients.z, g.z), 1e-4);

  FieldOutputs inferred;
  evaluate_field(field, batch.inputs(), inferred);
  EXPECT_EQ(inferred.sigma, fast.out.sigma);
  EXPECT_EQ(inferred.red, fast.out.red);
  EXPECT_EQ(inferred.green, fast.out.green);
  EXPECT_EQ(inferred.blue, fast.out.blue);
  std::vector<float> sigma;
  evaluate_density(field, batch.inputs(), sigma);
  EXPECT_LE(relative_l2(sigma, out.sigma), 1e-5);

  GeometryFeatures geometry;
  FieldOutputs colours;
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t n = 0; n < sigma.size(); n += 1 + n % 3) chosen.push_back(n);
  evaluate_density(field, batch.inputs(), sigma, geometry);
  evaluate_colour(field, batch.inputs(), geometry, chosen, colours);
  EXPECT_EQ(sigma, inferred.sigma);
  ASSERT_EQ(colours.red.size(), chosen.size());
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    EXPECT_EQ(colours.red[k], inferred.red[chosen[k]]);
    EXPECT_EQ(colours.green[k], inferred.green[chosen[k]]);
    EXPECT_EQ(colours.blue[k], inferred.blue[chosen[k]]);
  }
}

// Each instruction set in turn, then all again.
class WithTarget {
 public:
  explicit WithTarget(std::int64_t target) { hwy::SetSupportedTargetsForTest(target); }
  ~WithTarget() { hwy::SetSupportedTargetsForTest(0); }
};
std::vector<std::int64_t> targets() {
  std::vector<std::int64_t> list;
  for (std::int64_t target : {HWY_AVX3, HWY_AVX2, HWY_SSSE3, HWY_NEON}) {
    if (hwy::SupportedTargets() & target) list.push_back(target);
  }
  EXPECT_FALSE(list.empty());
  return list;
}

class FieldEvaluate : public testing::TestWithParam<NamedConfig> {};

TEST_P(FieldEvaluate, MatchesTheReferenceOnEveryInstructionSet) {
  const Field field = trained_like_field(GetParam().config, 3);
  const Batch batch = random_batch(field.config, 777, 5, 4);  // neither whole tiles nor whole vectors
  for (std::int64_t target : targets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    const WithTarget chosen(target);
    expect_parity(field, batch);
  }
}

INSTANTIATE_TEST_SUITE_P(Configs, FieldEvaluate, testing::ValuesIn(small_configs()),
                         [](const auto& info) { return info.param.name; });

FieldConfig full_config() {
  FieldConfig config;
  config.condition_count = 6;
  config.latent_count = 8;
  return config;
}

TEST(FieldEvaluateFull, MatchesTheReferenceAtTheDefaultSizeOverSeveralChunks) {
  const Field field = trained_like_field(full_config(), 5);
  expect_parity(field, random_batch(field.config, 9000, 40, 6));
}

TEST(FieldEvaluateFull, RepeatsBitForBitWithAnyNumberOfThreads) {
  const Field field = trained_like_field(full_config(), 7);
  const Batch batch = random_batch(field.config, 20000, 40, 8);
  const Trained first = run(field, batch), again = run(field, batch);
  EXPECT_EQ(first.out.sigma, again.out.sigma);
  EXPECT_EQ(first.gradients.parameters, again.gradients.parameters);
  const ThreadLimit one(1);
  const Trained alone = run(field, batch);
  EXPECT_EQ(first.out.sigma, alone.out.sigma);
  EXPECT_EQ(first.out.red, alone.out.red);
  EXPECT_EQ(first.gradients.parameters, alone.gradients.parameters);
  EXPECT_EQ(first.gradients.touched, alone.gradients.touched);
  EXPECT_EQ(first.gradients.latents, alone.gradients.latents);
}

TEST(FieldEvaluateFull, ASampleDoesNotDependOnItsBatch) {
  const Field field = trained_like_field(full_config(), 9);
  const Batch batch = random_batch(field.config, 1000, 3, 10);
  FieldOutputs whole;
  evaluate_field(field, batch.inputs(), whole);
  for (std::size_t count : {1, 15, 17, 63, 65}) {
    FieldInputs some = batch.inputs();
    some.count = count;
    FieldOutputs part;
    evaluate_field(field, some, part);
    ASSERT_EQ(part.sigma.size(), count);
    for (std::size_t n = 0; n < count; ++n) {
      EXPECT_EQ(part.sigma[n], whole.sigma[n]);
      EXPECT_EQ(part.blue[n], whole.blue[n]);
    }
  }
}

TEST(FieldEvaluateEdges, AnEmptyBatchGivesNothingAndChangesNothing) {
  const Field field = trained_like_field(small_configs()[0].config, 11);
  const Trained t = run(field, Batch{.views = 1});
  EXPECT_TRUE(t.out.sigma.empty());
  EXPECT_TRUE(t.out.red.empty());
  for (float g : t.gradients.parameters) EXPECT_EQ(g, 0.0f);
  std::vector<float> sigma(3);
  evaluate_density(field, {}, sigma);
  EXPECT_TRUE(sigma.empty());
}

TEST(FieldEvaluateEdges, FacesOfTheCubeMatchTheReferenceAndBeyondThemTheFieldIsConstant) {
  const Field field = trained_like_field(small_configs()[0].config, 13);
  Batch batch = random_batch(field.config, 128, 2, 14);
  for (std::size_t n = 0; n < 128; ++n) {
    batch.x[n] = float(n & 1), batch.y[n] = float((n >> 1) & 1), batch.z[n] = float((n >> 2) & 1);
  }
  const std::vector<double> parameters(field.parameters.begin(), field.parameters.end());
  const auto samples = reference_samples<double>(field.config, batch.inputs(), batch.views);
  const auto truth = reference_forward<double>(field.config, parameters, samples);
  FieldOutputs on, beyond;
  evaluate_field(field, batch.inputs(), on);
  EXPECT_LE(relative_l2(on.sigma, truth.sigma), 1e-5);
  for (std::size_t n = 0; n < 128; ++n) batch.x[n] = batch.x[n] > 0 ? 1.5f : -3.0f;
  evaluate_field(field, batch.inputs(), beyond);
  EXPECT_EQ(on.sigma, beyond.sigma);
  EXPECT_EQ(on.green, beyond.green);
}

TEST(FieldEvaluateEdges, HugeWeightsAndPositionsThatAreNotNumbersStayInBounds) {
  Field field = trained_like_field(full_config(), 15);
  const Batch batch = random_batch(field.config, 300, 3, 16);
  for (float& p : field.parameters) p *= 1e4f;
  const Trained t = run(field, batch);
  for (std::size_t n = 0; n < 300; ++n) {
    EXPECT_TRUE(std::isfinite(t.out.sigma[n]) && t.out.sigma[n] >= 0) << t.out.sigma[n];
    for (float v : {t.out.red[n], t.out.green[n], t.out.blue[n]}) EXPECT_TRUE(v >= 0 && v <= 1) << v;
  }
  for (float g : t.gradients.parameters) ASSERT_TRUE(std::isfinite(g));
  Batch broken = batch;
  broken.x.assign(300, std::numeric_limits<float>::quiet_NaN());
  broken.y.assign(300, std::numeric_limits<float>::infinity());
  FieldOutputs out;
  evaluate_field(field, broken.inputs(), out);  // must not read outside its tables
  EXPECT_EQ(out.sigma.size(), 300u);
}

TEST(FieldEvaluateEdges, MissingDirectionsViewsAndLatentsMeanForwardRowZeroAndZero) {
  const Field field = trained_like_field(small_configs()[0].config, 17);
  Batch batch = random_batch(field.config, 100, 2, 18);
  FieldInputs bare = batch.inputs();
  bare.dx = bare.dy = bare.dz = nullptr;
  bare.view = nullptr;
  bare.latents = nullptr;
  batch.dx.assign(100, 0.0f), batch.dy.assign(100, 0.0f), batch.dz.assign(100, 1.0f);
  batch.view.assign(100, 0);
  batch.latents.assign(batch.latents.size(), 0.0f);
  FieldOutputs a, b;
  evaluate_field(field, bare, a);
  evaluate_field(field, batch.inputs(), b);
  EXPECT_EQ(a.sigma, b.sigma);
  EXPECT_EQ(a.red, b.red);
}

TEST(FieldEvaluateEdgesDeathTest, AViewWithoutARowOfGradientsIsReportedNotWritten) {
  const Field field = trained_like_field(small_configs()[0].config, 21);
  Batch batch = random_batch(field.config, 64, 4, 22);
  batch.view[17] = 3;
  batch.views = 3;  // gradients are made for rows 0 to 2
  EXPECT_DEATH(run(field, batch), "views 0 to 3");
}

TEST(FieldGradientsTouched, LinesWithAGradientAreMarkedAndNoOthers) {
  const Field field = trained_like_field(full_config(), 19);
  Batch batch = random_batch(field.config, 100, 2, 20);
  for (std::size_t n = 50; n < 100; ++n) batch.sigma[n] = batch.red[n] = batch.green[n] = batch.blue[n] = 0;
  const Trained t = run(field, batch);
  std::size_t marked = 0;
  for (std::size_t line = 0; line < t.gradients.touched.size(); ++line) {
    bool any = false;
    for (std::size_t i = 0; i < kTableLine; ++i) any |= t.gradients.parameters[line * kTableLine + i] != 0;
    EXPECT_LE(any, bool(t.gradients.touched[line])) << line;
    marked += t.gradients.touched[line];
  }
  EXPECT_GT(marked, 0u);
  EXPECT_LE(marked, 50u * (8 * 8 + 8 * 4));  // samples without gradient touch nothing
}

}  // namespace
}  // namespace likeness
