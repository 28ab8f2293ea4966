// A training before its first step: see training_state.h.
#include "core/train/training_state.h"

#include <algorithm>
#include <cmath>

#include "core/train/mode.h"
#include "core/train/refine_track.h"

namespace likeness {
namespace {

constexpr float kInitialDensity = 4;  // per cube side: a haze, so that the first gradients see every depth

FieldConfig head_config(int conditions, int attributes, const TrainOptions& options) {
  FieldConfig config;
  config.initial_density = kInitialDensity;
  config.position = {3, 8, 4, options.fields.sizes.head_log2_entries, 16, options.fields.sizes.head_finest};
  config.condition_count = conditions + attributes, config.local_conditions = attributes;
  config.ambient = mode_parts(options.fields.mode).ambient;
  config.ambient_grid = {2, 8, 4, 14, 8, 64};
  config.density_layers = 1;
  config.latent_count = options.fields.use_latent ? options.fields.sizes.code_length : 0;
  return config;
}

FieldConfig torso_config(const FieldSizes& sizes) {
  FieldConfig config;
  config.initial_density = kInitialDensity;
  config.position = {3, 8, 4, sizes.torso_log2_entries, 16, sizes.torso_finest};
  config.density_width = 32, config.density_layers = 1;
  config.colour_width = 32, config.colour_layers = 1;
  config.view_direction = false;
  return config;
}

TrainedField make_trained_field(const FieldConfig& config, const Volume& volume, std::uint32_t seed) {
  TrainedField field;
  field.volume = volume;
  field.part.field = make_field(config, seed);
  field.part.cube = volume.cube;
  field.part.occupancy = volume.allowed;
  field.part.core = volume.core;
  field.adam = make_adam_state(field.part.field);
  field.learnt = make_occupancy_state(volume);
  return field;
}

}  // namespace

bool is_finite(const TrainingState& state) {
  const auto finite = [](const std::vector<float>& values) {
    return std::ranges::all_of(values, [](float v) { return std::isfinite(v); });
  };
  const auto field = [&](const TrainedField& f) {
    return finite(f.part.field.parameters) && finite(f.adam.first) && finite(f.adam.second);
  };
  return field(state.head) && (!state.torso || field(*state.torso)) && finite(state.codes) &&
         finite(state.codes_adam.first) && finite(state.codes_adam.second);
}

TrainingState make_training_state(const TrainingSet& set, const TrainOptions& options,
                                  const ConditionMap& map, const Volumes& volumes) {
  TrainingState state;
  const std::size_t views = pictured(set);
  const int k = int(map.rows.rows());
  const auto seed = std::uint32_t(options.seed * 2);
  state.head = make_trained_field(head_config(k, int(set.attributes.size()), options), volumes.head, seed);
  if (options.rays.canonical_occupancy)
    state.head.canonical = make_canonical_state(volumes.head.allowed.resolution);
  if (volumes.torso)
    state.torso = make_trained_field(torso_config(options.fields.sizes), *volumes.torso, seed + 1);
  const std::size_t length = std::size_t(state.head.part.field.config.latent_count);
  state.codes.assign(2 * views * length, 0.f);
  set_conditions(state, map, pictured_poses(set, map, {}), set.attributes);
  state.schedule.total_steps = options.schedule.steps;
  state.schedule.rate_scale = options.schedule.rate;
  state.schedule.budget_s = options.schedule.steps > 0 ? 0 : options.schedule.budget_s;
  return state;
}

void set_conditions(TrainingState& state, const ConditionMap& map, std::span<const AvatarPose> poses,
                    std::span<const AttributeRegion> attributes) {
  const std::size_t views = poses.size(), k = std::size_t(map.rows.rows()) + attributes.size();
  state.conditions.resize(2 * views * k);
  for (std::size_t v = 0; v < views; ++v) {
    const Eigen::VectorXf psi = condition(map, poses[v].articulation, attributes, poses[v].attributes);
    for (const std::size_t row : {v, v + views})
      std::copy(psi.begin(), psi.end(), state.conditions.begin() + std::ptrdiff_t(row * k));
  }
  state.deviations.assign(k, 0.f);
  for (std::size_t i = 0; i < views * k; ++i)
    state.deviations[i % k] += state.conditions[i] * state.conditions[i] / float(views);
  for (float& deviation : state.deviations) deviation = std::sqrt(deviation);
}

}  // namespace likeness
