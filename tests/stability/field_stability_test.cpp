// Claims about fields whose parameters are extreme: solid, empty, denormal.
#include <gtest/gtest.h>

#include <cmath>

#include "core/field/train_fields.h"
#include "core/render/render.h"
#include "tests/core/field/random_field.h"
#include "tests/core/render/tiny_avatar.h"

namespace likeness {
namespace {

// Sets the bias of the density's output.
void set_raw_density(Field& field, float raw) {
  const auto blocks = parameter_layout(field.config);
  const auto is = [](const ParameterBlock& b, const char* what) {
    return b.name.find(what) != std::string::npos;
  };
  const ParameterBlock *weights = nullptr, *biases = nullptr;
  for (const ParameterBlock& b : blocks)
    if (!b.table && is(b, "density")) (b.rows > 0 ? weights : biases) = &b;
  ASSERT_NE(weights, nullptr);
  ASSERT_NE(biases, nullptr);
  std::fill_n(field.parameters.begin() + std::ptrdiff_t(weights->offset), weights->columns, 0.f);
  field.parameters[biases->offset] = raw;
}

TEST(FieldStability, EmptyAndSolidFieldsRenderAsGlassAndWall) {
  for (const float raw : {-200.f, -1e30f, 20.f, 200.f, 1e6f}) {
    Avatar a = tiny_avatar();
    set_raw_density(a.head.field, raw);
    set_raw_density(a.torso->field, raw);
    const RenderedFrame frame = render_frame(a, typical_camera(a), typical_state(a));
    float most = 0;
    for (std::size_t i = 0; i < frame.rgba.pixels(); ++i) {
      const float* p = frame.rgba.data.data() + 4 * i;
      for (int c = 0; c < 4; ++c) ASSERT_TRUE(p[c] >= 0 && p[c] <= 1 + 1e-6f) << raw << ": " << p[c];
      most = std::max(most, p[3]);
    }
    if (raw < 0)
      EXPECT_LT(most, 1e-6f) << raw;
    else
      EXPECT_GT(most, 1 - 1e-6f) << raw;
  }
}

TEST(FieldStability, DenormalParametersGiveFiniteOutputsAndGradients) {
  FieldConfig config;
  config.position = {3, 4, 4, 12, 4, 32};
  config.ambient_grid = {2, 4, 4, 10, 4, 16};
  config.condition_count = 2, config.latent_count = 2;
  Field field = make_field(config, 1);
  for (float& p : field.parameters) p *= 1e-38f;
  Batch batch = random_batch(config, 500, 3, 2);
  for (const FieldPrecision precision : {FieldPrecision::exact, FieldPrecision::bf16}) {
    FieldOutputs out;
    FieldGradients gradients = make_gradients(field, 3);
    const auto tape = make_tape();
    train_field(field, batch.inputs(), out, batch.output_gradients(), *tape, gradients, precision);
    for (std::size_t i = 0; i < 500; ++i) {
      ASSERT_TRUE(std::isfinite(out.sigma[i]) && out.sigma[i] > 0);
      for (const float c : {out.red[i], out.green[i], out.blue[i]}) ASSERT_NEAR(c, 0.5f, 1e-6f);
    }
    for (const float g : gradients.parameters) ASSERT_TRUE(std::isfinite(g));
  }
}

}  // namespace
}  // namespace likeness
