// Random fields and batches of samples for the field's tests and benchmarks.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/field/evaluate.h"
#include "core/field/field.h"
#include "core/field/field_reference.h"

namespace likeness {

struct Batch {
  std::size_t views = 0;
  std::vector<float> x, y, z, dx, dy, dz, conditions, latents;
  std::vector<std::int32_t> view;
  std::vector<float> sigma, red, green, blue;  // gradients of the outputs
  std::vector<float> local;                    // (local conditions, N); empty: none

  FieldInputs inputs() const {
    return {x.size(),
            x.data(),
            y.data(),
            z.data(),
            dx.data(),
            dy.data(),
            dz.data(),
            view.data(),
            conditions.data(),
            latents.empty() ? nullptr : latents.data(),
            local.empty() ? nullptr : local.data()};
  }
  FieldOutputGradients output_gradients() const {
    return {sigma.data(), red.data(), green.data(), blue.data()};
  }
};

inline Batch random_batch(const FieldConfig& config, std::size_t count, std::size_t views,
                          std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  std::normal_distribution<float> normal;
  Batch batch;
  batch.views = views;
  for (std::size_t n = 0; n < count; ++n) {
    batch.x.push_back(unit(random)), batch.y.push_back(unit(random)), batch.z.push_back(unit(random));
    float d[3] = {normal(random), normal(random), normal(random)};
    const float length = std::hypot(d[0], d[1], d[2]) + 1e-6f;
    batch.dx.push_back(d[0] / length), batch.dy.push_back(d[1] / length), batch.dz.push_back(d[2] / length);
    batch.view.push_back(std::int32_t(random() % views));
    batch.sigma.push_back(normal(random)), batch.red.push_back(normal(random));
    batch.green.push_back(normal(random)), batch.blue.push_back(normal(random));
  }
  for (std::size_t i = 0; i < views * config.condition_count; ++i) batch.conditions.push_back(normal(random));
  for (std::size_t i = 0; i < views * config.latent_count; ++i) batch.latents.push_back(normal(random));
  for (std::size_t i = 0; i < count * config.local_conditions; ++i)
    batch.local.push_back(i % 4 == 0 ? 0.0f : unit(random));
  return batch;
}

// A field as after training: tables of a size that matters, biases that are not zero.
inline Field trained_like_field(const FieldConfig& config, std::uint32_t seed, float table_scale = 0.5f) {
  Field field = make_field(config, seed);
  std::mt19937 random(seed + 1);
  std::uniform_real_distribution<float> value(-1.0f, 1.0f);
  for (const ParameterBlock& block : parameter_layout(config)) {
    if (!block.table && block.rows > 0) continue;
    for (std::size_t i = 0; i < block.count; ++i) {
      field.parameters[block.offset + i] = (block.table ? table_scale : 0.2f) * value(random);
    }
  }
  return field;
}

// Configurations that between them reach every branch, small enough to be tested parameter by parameter.
struct NamedConfig {
  std::string name;
  FieldConfig config;
};
// with_local: also some whose conditions act in a region, which devices do not support.
inline std::vector<NamedConfig> small_configs(bool with_local = true) {
  FieldConfig base;
  base.position = {3, 3, 4, 8, 4, 13};  // the finest level is hashed: 14^3 > 2^8
  base.ambient_grid = {2, 2, 4, 9, 4, 9};
  base.condition_count = 3;
  base.slice_width = 8, base.slice_levels = 2;
  base.density_width = 12;
  base.geometry_features = 5;
  base.colour_width = 10;
  base.latent_count = 2;
  std::vector<NamedConfig> configs{{"Ambient2d", base}};
  FieldConfig c = base;
  c.ambient_grid = {3, 2, 2, 7, 3, 6};  // hashed from the first level or the second
  c.density_layers = 1, c.colour_layers = 1;
  configs.push_back({"Ambient3dShallow", c});
  c = base, c.ambient_grid = {1, 2, 4, 6, 3, 6}, c.position.features = 8;
  configs.push_back({"Ambient1dWideEntries", c});
  c = base, c.ambient = false;
  configs.push_back({"Concatenated", c});
  c = base, c.condition_count = 0;
  configs.push_back({"Unconditioned", c});
  c = base, c.latent_count = 0, c.view_direction = false, c.position.features = 1;
  configs.push_back({"NoLatentNoDirection", c});
  c = base, c.geometry_features = 0, c.position.features = 2;
  configs.push_back({"NoGeometryFeatures", c});
  if (!with_local) return configs;
  c = base, c.local_conditions = 2;
  configs.push_back({"Local", c});
  c = base, c.local_conditions = 1, c.ambient = false;
  configs.push_back({"LocalConcatenated", c});
  c = base, c.local_conditions = 3;
  configs.push_back({"LocalAlone", c});
  return configs;
}

}  // namespace likeness
