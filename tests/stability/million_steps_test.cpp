// A million steps on a tiny field: no drift, and no NaN.
#include <gtest/gtest.h>

#include <cmath>

#include "core/field/adam.h"
#include "core/field/train_fields.h"
#include "tests/core/field/random_field.h"

namespace likeness {
namespace {

// A ball whose place follows the condition, a new batch every step.
class TinyTraining {
 public:
  explicit TinyTraining(FieldPrecision precision)
      : precision_(precision),
        field_(make_field(config(), 1)),
        gradients_(make_gradients(field_, kViews)),
        adam_(make_adam_state(field_)) {}

  double step(std::uint32_t seed) {
    Batch batch = random_batch(field_.config, kSamples, kViews, seed);
    for (int v = 0; v < kViews; ++v) batch.conditions[std::size_t(v)] = float(v) / float(kViews - 1);
    double loss = 0;
    const auto compare = [&](std::size_t) {
      for (std::size_t n = 0; n < kSamples; ++n) {
        const float centre = 0.3f + 0.4f * batch.conditions[std::size_t(batch.view[n])];
        const bool inside = std::hypot(batch.x[n] - centre, batch.y[n] - 0.5f, batch.z[n] - 0.5f) < 0.25f;
        const float alpha = 1 - std::exp(-out_.sigma[n] / 20), miss = alpha - float(inside),
                    off = out_.red[n] - batch.y[n];
        loss += (miss * miss + (inside ? off * off : 0)) / kSamples;
        batch.sigma[n] = 2 * miss * (1 - alpha) / 20 / kSamples;
        batch.red[n] = inside ? 2 * off / kSamples : 0;
        batch.green[n] = batch.blue[n] = 0;
      }
    };
    const std::size_t end = kSamples;
    const FieldStep step{field_, batch.inputs(), {&end, 1}, out_, batch.output_gradients(),
                         *tape_, gradients_,     precision_};
    train_fields({&step, 1}, compare);
    adam_step(field_, gradients_, adam_, {});
    return loss;
  }
  const Field& field() const { return field_; }

 private:
  static constexpr std::size_t kSamples = 64;
  static constexpr int kViews = 4;
  static FieldConfig config() {
    FieldConfig c;
    c.position = {3, 2, 2, 8, 4, 8};
    c.ambient_grid = {2, 2, 2, 6, 4, 8};
    c.condition_count = 1, c.slice_width = 8;
    c.density_width = c.colour_width = 8;
    c.density_layers = c.colour_layers = 1;
    return c;
  }
  FieldPrecision precision_;
  Field field_;
  FieldGradients gradients_;
  AdamState adam_;
  FieldOutputs out_;
  std::shared_ptr<FieldTape> tape_ = make_tape();
};

class MillionSteps : public testing::TestWithParam<FieldPrecision> {};
INSTANTIATE_TEST_SUITE_P(Precisions, MillionSteps,
                         testing::Values(FieldPrecision::exact, FieldPrecision::bf16), [](const auto& info) {
                           return info.param == FieldPrecision::exact ? "Exact" : "Bf16";
                         });

TEST_P(MillionSteps, NeitherDriftNorBecomeNaN) {
  TinyTraining training(GetParam());
  constexpr std::uint32_t kBlock = 20000, kBlocks = 50;
  double early = 0, worst = 0;
  for (std::uint32_t block = 0; block < kBlocks; ++block) {
    double mean = 0;
    for (std::uint32_t i = 0; i < kBlock; ++i) {
      const double loss = training.step(block * kBlock + i);
      ASSERT_TRUE(std::isfinite(loss)) << block * kBlock + i;
      mean += loss / kBlock;
    }
    float largest = 0;
    for (const float p : training.field().parameters) {
      ASSERT_TRUE(std::isfinite(p));
      largest = std::max(largest, std::abs(p));
    }
    EXPECT_LT(largest, 1e4f) << "after " << (block + 1) * kBlock << " steps";
    if (block == 1) early = mean;
    if (block > 1) worst = std::max(worst, mean);
  }
  EXPECT_LT(worst, 1.5 * early + 1e-4) << "learnt to " << early;
}

}  // namespace
}  // namespace likeness
