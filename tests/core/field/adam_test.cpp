// Claims about core/field/adam.h.
#include "core/field/adam.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/field/evaluate.h"
#include "tests/core/field/random_field.h"

namespace likeness {
namespace {

FieldConfig tiny_config() {
  FieldConfig config = small_configs()[0].config;
  config.latent_count = 0;
  return config;
}

// Adam as the paper writes it, in double, for one value.
struct PaperAdam {
  double m = 0, v = 0;
  int t = 0;
  double step(double value, double gradient, double rate, const AdamOptions& o, double epsilon) {
    ++t;
    m = o.beta1 * m + (1 - o.beta1) * gradient;
    v = o.beta2 * v + (1 - o.beta2) * gradient * gradient;
    const double m_hat = m / (1 - std::pow(double(o.beta1), t)),
                 v_hat = v / (1 - std::pow(double(o.beta2), t));
    return value - rate * m_hat / (std::sqrt(v_hat) + epsilon);
  }
};

TEST(Adam, FindsTheMinimumOfAQuadraticOverEveryParameter) {
  Field field = make_field(tiny_config(), 1);
  const std::size_t count = field.parameters.size();
  FieldGradients gradients = make_gradients(field, 1);
  AdamState state = make_adam_state(field);
  AdamOptions options;
  options.table_rate = options.network_rate = 2e-2f;
  const auto target = [](std::size_t i) { return 0.5f * std::sin(float(i)); };
  for (int step = 0; step < 600; ++step) {
    if (step == 400) options.table_rate = options.network_rate = 1e-3f;
    for (std::size_t i = 0; i < count; ++i) {
      gradients.parameters[i] = float(1 + i % 7) * (field.parameters[i] - target(i));
    }
    gradients.touched.assign(gradients.touched.size(), 1);
    adam_step(field, gradients, state, options);
  }
  for (std::size_t i = 0; i < count; ++i) ASSERT_NEAR(field.parameters[i], target(i), 2e-3f) << i;
}

// A rate far too high decays a table's values to zero, without changing their signs and diverging.
TEST(Adam, DecayNeverTakesMoreThanTheWholeValue) {
  AdamOptions options;
  options.table_rate = 1e4f, options.table_decay = 0.1f;
  EXPECT_EQ(options.table_keep(), 0);
  options.table_rate = 0.01f;
  EXPECT_FLOAT_EQ(options.table_keep(), 0.999f);
  Field field = trained_like_field(tiny_config(), 2);
  FieldGradients gradients = make_gradients(field, 1);
  AdamState state = make_adam_state(field);
  options.table_rate = 1e4f;
  for (int step = 0; step < 40; ++step) {
    gradients.touched[0] = 1;
    adam_step(field, gradients, state, options);
  }
  EXPECT_EQ(field.parameters[3], 0);  // without a gradient nothing else moves it
}

TEST(Adam, FollowsThePaperStepByStepInTablesAndNetworks) {
  Field field = trained_like_field(tiny_config(), 2);
  FieldGradients gradients = make_gradients(field, 1);
  AdamState state = make_adam_state(field);
  AdamOptions options;
  options.network_l2 = 0.01f, options.table_decay = 0.3f;
  const std::vector<ParameterBlock> layout = parameter_layout(field.config);
  const ParameterBlock& weights = layout[layout.size() - 2];  // colour.weights2
  const ParameterBlock& biases = layout.back();
  ASSERT_GT(weights.rows, 0);
  struct Tracked {
    std::size_t at;
    double rate, l2, decay, value;
    PaperAdam adam;
  };
  std::vector<Tracked> tracked = {
      {3, options.table_rate, 0, options.table_decay, field.parameters[3], {}},
      {weights.offset, options.network_rate, 0.01, 0, field.parameters[weights.offset], {}},
      {biases.offset, options.network_rate, 0, 0, field.parameters[biases.offset], {}}};
  for (int step = 0; step < 30; ++step) {
    gradients.touched[0] = 1;
    for (Tracked& p : tracked) {
      const float g = std::cos(float(step) + float(p.at % 11));
      gradients.parameters[p.at] = g;
      p.value = p.adam.step(p.value * (1 - p.decay * p.rate), g + p.l2 * p.value, p.rate, options, 0);
    }
    adam_step(field, gradients, state, options);
    for (const Tracked& p : tracked)
      ASSERT_NEAR(field.parameters[p.at], p.value, 1e-5) << p.at << " step " << step;
  }
}

TEST(Adam, SparseStepsEqualDenseOnesOnTouchedLinesAndLeaveOthersAlone) {
  const Field start = trained_like_field(tiny_config(), 3);
  Field sparse = start, dense = start;
  AdamState sparse_state = make_adam_state(start), dense_state = make_adam_state(start);
  FieldGradients sparse_gradients = make_gradients(start, 1), dense_gradients = sparse_gradients;
  const std::size_t lines = sparse_gradients.touched.size();
  const auto chosen = [](std::size_t line) { return line % 3 == 0 || line % 16 == 7; };
  for (int step = 0; step < 20; ++step) {
    for (std::size_t i = 0; i < lines * kTableLine; ++i) {
      if (!chosen(i / kTableLine)) continue;
      sparse_gradients.parameters[i] = dense_gradients.parameters[i] =
          std::sin(float(i) + 0.7f * float(step));
    }
    for (std::size_t line = 0; line < lines; ++line) sparse_gradients.touched[line] = chosen(line);
    dense_gradients.touched.assign(lines, 1);
    adam_step(sparse, sparse_gradients, sparse_state, {});
    adam_step(dense, dense_gradients, dense_state, {});
  }
  for (std::size_t i = 0; i < lines * kTableLine; ++i) {
    if (chosen(i / kTableLine)) {
      ASSERT_EQ(sparse.parameters[i], dense.parameters[i]) << i;
      ASSERT_NE(sparse.parameters[i], start.parameters[i]) << i;
    } else {
      ASSERT_EQ(sparse.parameters[i], start.parameters[i]) << i;
    }
  }
}

TEST(Adam, ALineFirstTouchedLateStartsWithItsOwnBiasCorrection) {
  Field field = trained_like_field(tiny_config(), 4);
  FieldGradients gradients = make_gradients(field, 1);
  AdamState state = make_adam_state(field);
  for (int step = 0; step < 50; ++step) {
    gradients.touched[0] = 1, gradients.parameters[0] = 1;
    adam_step(field, gradients, state, {});
  }
  const float before = field.parameters[kTableLine];
  gradients.touched[0] = gradients.touched[1] = 1;
  gradients.parameters[kTableLine] = 1e-9f;  // far below any usual epsilon
  adam_step(field, gradients, state, {});
  EXPECT_NEAR(field.parameters[kTableLine], before - AdamOptions{}.table_rate, 1e-4f);
  EXPECT_EQ(state.line_steps[0], 51u);
  EXPECT_EQ(state.line_steps[1], 1u);
}

TEST(Adam, ClearsTheGradientsItConsumed) {
  Field field = trained_like_field(tiny_config(), 5);
  FieldGradients gradients = make_gradients(field, 1);
  AdamState state = make_adam_state(field);
  for (std::size_t i = 0; i < gradients.parameters.size(); ++i) gradients.parameters[i] = 1;
  gradients.touched.assign(gradients.touched.size(), 1);
  adam_step(field, gradients, state, {});
  for (float g : gradients.parameters) ASSERT_EQ(g, 0.0f);
  for (std::uint8_t t : gradients.touched) ASSERT_EQ(t, 0);
}

TEST(Adam, ArraysOfOddLengthConverge) {
  std::vector<float> values(37, 1.0f), gradients(37);
  ArrayAdamState state;
  for (int step = 0; step < 800; ++step) {
    for (int i = 0; i < 37; ++i) gradients[i] = values[i] - 0.1f * float(i);
    adam_step(values, gradients, state, 1e-2f, {});
  }
  for (int i = 0; i < 37; ++i) EXPECT_NEAR(values[i], 0.1f * float(i), 2e-2f);
}

// The whole engine: a field learns a coloured ball that moves with the condition.
TEST(Adam, TrainsAFieldToAMovingBall) {
  FieldConfig config;
  config.position = {3, 4, 4, 12, 4, 32};
  config.ambient_grid = {2, 4, 4, 10, 4, 16};
  config.condition_count = 1;
  config.density_width = config.colour_width = 32;
  Field field = make_field(config, 6);
  const std::shared_ptr<FieldTape> tape = make_tape();
  FieldGradients gradients = make_gradients(field, 16);
  AdamState state = make_adam_state(field);
  const auto step = [&](std::uint32_t seed, bool train) {
    Batch batch = random_batch(config, 4096, 16, seed);
    for (int v = 0; v < 16; ++v) batch.conditions[v] = float(v) / 15;
    FieldOutputs out;
    double loss = 0;
    const auto compare = [&](std::size_t) {
      for (std::size_t n = 0; n < 4096; ++n) {
        const float centre = 0.3f + 0.4f * batch.conditions[batch.view[n]];
        const bool inside = std::hypot(batch.x[n] - centre, batch.y[n] - 0.5f, batch.z[n] - 0.5f) < 0.2f;
        // Opacity of a step of 1/20, and colour where there is something.
        const float alpha = 1 - std::exp(-out.sigma[n] / 20), miss = alpha - float(inside);
        const float tint[3] = {out.red[n] - batch.y[n], out.green[n] - 0.2f, out.blue[n] - batch.z[n]};
        batch.sigma[n] = 2 * miss * (1 - alpha) / 20 / 4096;
        float* colour[3] = {&batch.red[n], &batch.green[n], &batch.blue[n]};
        for (int c = 0; c < 3; ++c) {
          *colour[c] = inside ? 2 * tint[c] / 4096 : 0.0f;
          if (inside) loss += tint[c] * tint[c] / 4096;
        }
        loss += miss * miss / 4096;
      }
    };
    if (train) {
      const std::size_t end = 4096;
      const FieldStep pass{field, batch.inputs(), {&end, 1}, out, batch.output_gradients(), *tape, gradients};
      train_fields({&pass, 1}, compare);
      adam_step(field, gradients, state, {});
    } else {
      evaluate_field(field, batch.inputs(), out);
      compare(0);
    }
    return loss;
  };
  const double before = step(1000, false);
  for (std::uint32_t i = 0; i < 150; ++i) step(i, true);
  const double after = step(1000, false);
  EXPECT_LT(after, 0.25 * before) << before;
}

}  // namespace
}  // namespace likeness
