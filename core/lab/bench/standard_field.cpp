// The timed field and its samples: see standard_field.h.
#include "core/lab/bench/standard_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace likeness {
namespace {

constexpr std::size_t kSamplesPerRay = 16, kViews = 64;

// The distributions of standard libraries differ; this one is the same everywhere.
struct Random {
  std::mt19937 engine;
  float uniform(float low, float high) { return low + (high - low) * (float(engine() >> 8) * 0x1p-24f); }
};

}  // namespace

FieldConfig standard_field_config() {
  FieldConfig config;
  config.position = {3, 16, 2, 16, 16, 512};
  config.ambient_grid = {2, 16, 2, 14, 8, 127};
  config.condition_count = 8;
  config.slice_width = 32;
  config.slice_levels = 16;
  config.density_width = 64, config.density_layers = 1;
  config.geometry_features = 15;
  config.colour_width = 64, config.colour_layers = 2;
  config.latent_count = 7;
  return config;
}

Field standard_field(std::uint32_t seed) {
  Field field = make_field(standard_field_config(), seed);
  Random random{std::mt19937(seed + 1)};
  for (const ParameterBlock& block : parameter_layout(field.config)) {
    if (!block.table && block.rows > 0) continue;
    for (std::size_t i = 0; i < block.count; ++i)
      field.parameters[block.offset + i] = random.uniform(-0.2f, 0.2f);
  }
  return field;
}

FieldInputs StandardBatch::inputs() const {
  return {x.size(),  x.data(),  y.data(),    z.data(),          dx.data(),
          dy.data(), dz.data(), view.data(), conditions.data(), latents.data()};
}

FieldOutputGradients StandardBatch::gradients() const {
  return {sigma.data(), red.data(), green.data(), blue.data()};
}

StandardBatch standard_batch(const FieldConfig& config, std::size_t count, std::uint32_t seed) {
  Random random{std::mt19937(seed)};
  StandardBatch batch;
  batch.views = kViews;
  std::array<float, 3> from{}, to{};
  std::int32_t view = 0;
  for (std::size_t n = 0; n < count; ++n) {
    if (n % kSamplesPerRay == 0) {
      for (std::size_t a = 0; a < 3; ++a) from[a] = random.uniform(0, 1), to[a] = random.uniform(0, 1);
      view = std::int32_t(random.engine() % kViews);
    }
    const float t = (float(n % kSamplesPerRay) + random.uniform(0, 1)) / float(kSamplesPerRay);
    const float d[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    const float length = std::max(1e-3f, std::hypot(d[0], d[1], d[2]));
    batch.x.push_back(from[0] + t * d[0]), batch.y.push_back(from[1] + t * d[1]);
    batch.z.push_back(from[2] + t * d[2]);
    batch.dx.push_back(d[0] / length), batch.dy.push_back(d[1] / length), batch.dz.push_back(d[2] / length);
    batch.view.push_back(view);
    for (std::vector<float>* gradient : {&batch.sigma, &batch.red, &batch.green, &batch.blue})
      gradient->push_back(random.uniform(-1, 1));
  }
  const auto codes = [&](std::vector<float>& to_fill, int width) {
    to_fill.resize(kViews * std::size_t(width));
    for (float& v : to_fill) v = random.uniform(-1, 1);
  };
  codes(batch.conditions, config.condition_count);
  codes(batch.latents, config.latent_count);
  return batch;
}

}  // namespace likeness
