// One training step.
#include "core/train/training_step.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/render/pose_avatar.h"
#include "core/train/cast_rays.h"
#include "core/train/random_stream.h"
#include "core/train/refine_track.h"
#include "core/train/sides_seen.h"
#include "core/train/still_cells.h"

namespace likeness {
namespace {

constexpr std::uint64_t kFirstRefresh = 128, kRefreshEvery = 32;
constexpr float kTableRate = 1e-2f, kNetworkRate = 3e-3f, kCodeRate = 1e-3f;
// Without it, three thousand steps leave more specks around the lips.
constexpr float kTableDecay = 0.1f;
constexpr float kConditionBlur = 0.2f;  // largest shift of psi, in deviations of each component
constexpr float kInitialDensity = 4;    // per cube side: a haze, so that the first gradients see every depth
constexpr float kCodePenalty = 1e-4f;   // weight of the codes' mean square in the loss

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

// index: of the field, for the learner.
Result<void> refresh(TrainedField& field, FieldLearner& learner, int index, const TrainingState& state,
                     std::size_t views, const std::function<void(FieldSamples&)>& to_canonical,
                     std::uint64_t seed) {
  const auto densities = [&](const FieldInputs& inputs, std::vector<float>& sigma) -> Result<void> {
    if (auto found = learner.densities(index, inputs, sigma); !found) return found;
    if (field.canonical) add_cell_samples(*field.canonical, inputs, sigma);
    return {};
  };
  if (auto done = refresh_occupancy(field.learnt, field.part.occupancy.resolution, state.conditions.data(),
                                    views, to_canonical, densities, seed, state.step);
      !done)
    return done;
  field.part.occupancy = occupancy_bits(field.learnt, field.volume);
  field.part.opacity = cell_opacities(field.learnt, field.volume);
  return {};
}

// The expression of rays without a code is also perturbed a little, so that the slice is smooth between the
// frames.
void blur_conditions(TrainingState& state, std::size_t views, std::uint64_t seed) {
  const std::size_t half = state.conditions.size() / 2, k = views == 0 ? 0 : half / views;
  for (std::size_t v = 0; v < views && k > 0; ++v) {
    RandomStream random(seed ^ 0x9517ull, state.step, v);
    for (std::size_t i = v * k; i < (v + 1) * k; ++i)
      state.conditions[half + i] =
          state.conditions[i] + kConditionBlur * state.deviations[i % k] * (2 * random.uniform() - 1);
  }
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
  const std::size_t views = set.views.size();
  const int k = int(map.rows.rows());
  const auto seed = std::uint32_t(options.seed * 2);
  state.head = make_trained_field(head_config(k, int(set.attributes.size()), options), volumes.head, seed);
  if (options.rays.canonical_occupancy)
    state.head.canonical = make_canonical_state(volumes.head.allowed.resolution);
  if (volumes.torso)
    state.torso = make_trained_field(torso_config(options.fields.sizes), *volumes.torso, seed + 1);
  const std::size_t length = std::size_t(state.head.part.field.config.latent_count);
  state.codes.assign(2 * views * length, 0.f);
  set_conditions(state, map, corrected_poses(set, map, {}), set.attributes);
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

Result<std::unique_ptr<FieldLearner>> make_learner(Backend& backend, TrainingState& state,
                                                   const StepOptions& options, const TrainingSet& set) {
  LearntParts parts;
  parts.fields[0] = {&state.head.part.field, &state.head.adam};
  if (state.torso) parts.fields[1] = {&state.torso->part.field, &state.torso->adam};
  parts.codes = &state.codes, parts.codes_adam = &state.codes_adam;
  return backend.make_learner(parts, {std::size_t(options.rays), std::size_t(kTrainingSamples),
                                      set.views.size(), own_views(set).size(), options.landmark_weight > 0});
}

void cast_rays(TrainingState& state, const RaySource& source, const StepOptions& options) {
  const std::size_t views = source.views.size();
  MarchVolumes volumes =
      march_volumes(state.head.part, state.torso ? &state.torso->part : nullptr, source.necks);
  volumes.max_samples = kTrainingSamples;
  volumes.even_share = options.even_samples;
  CanonicalCells canonical;
  if (state.head.canonical) {
    const Volume& posed = state.head.volume;
    canonical = canonical_cells(*state.head.canonical, posed, source.warps);
    volumes.fields[0] = march_volume(posed.allowed, posed.core, posed.cube.side);
    volumes.canonical = &canonical;
  }
  choose_rays(source, volumes, options.use_latent, options.seed, state.step, options.rays, state.rays);
  sample_rays(state.rays.requests, volumes, state.samples);
  warp_samples(source.warps, state.head.part.cube, state.samples.fields[0]);
  straighten_samples(source.necks, state.samples.fields[0]);
  weigh_attributes(source.set->attributes, state.head.part.cube, state.samples.fields[0]);
  shuffle_conditions(state.head.volume.still, views, own_views(*source.set).size(), options.seed, state.step,
                     state.samples.fields[0]);
  if (options.use_latent)
    drop_codes_on_new_sides(source.sides, views, own_views(*source.set).size(), options.seed, state.step,
                            state.samples.fields[0]);
  if (state.torso) warp_samples(source.torsos, state.torso->part.cube, state.samples.fields[1]);
}

Result<void> refresh_fields(TrainingState& state, FieldLearner& learner, const RaySource& source,
                            std::uint64_t seed) {
  const std::size_t views = source.views.size();
  const auto head_to_canonical = [&](FieldSamples& samples) {
    warp_samples(source.warps, state.head.part.cube, samples);
    straighten_samples(source.necks, samples);
    weigh_attributes(source.set->attributes, state.head.part.cube, samples);
  };
  if (auto done = refresh(state.head, learner, 0, state, views, head_to_canonical, seed); !done) return done;
  const auto torso_to_canonical = [&](FieldSamples& samples) {
    warp_samples(source.torsos, state.torso->part.cube, samples);
  };
  return state.torso ? refresh(*state.torso, learner, 1, state, views, torso_to_canonical, seed)
                     : Result<void>();
}

Result<StepResult> training_step(TrainingState& state, FieldLearner& learner, const RaySource& source,
                                 const StepOptions& options, RayCaster* caster) {
  const std::size_t views = source.views.size();
  blur_conditions(state, views, options.seed);
  if (!caster) {
    cast_rays(state, source, options);
  } else if (auto done = caster->set_step(state.step); !done) {
    return done.error();
  }

  // -- Fields, loss, gradients, Adam.
  const double rate = learning_rate(state.step, state.schedule);
  LearningStep step{state.samples, state.rays.target, state.rays.background, state.conditions, views};
  step.table_rate = float(kTableRate * rate), step.network_rate = float(kNetworkRate * rate);
  step.table_decay = kTableDecay;
  step.code_rate = options.use_latent ? kCodeRate * step.network_rate / kNetworkRate : 0;
  step.code_penalty = kCodePenalty;
  step.patches = state.rays.patches, step.patch_weight = float(options.landmark_weight);
  if (caster) step.cast = caster, step.cast_rays = std::size_t(options.rays);
  const auto learnt = learner.step(step);
  if (!learnt) return learnt.error();
  StepResult result;
  result.loss = learnt->loss, result.landmark_loss = learnt->patch_loss;
  result.samples = learnt->samples[0] + learnt->samples[1];
  if (!std::isfinite(result.loss + result.landmark_loss)) {
    result.finite = false;
    return result;
  }
  ++state.step;

  // -- Occupancy.
  if (options.use_occupancy && state.step >= kFirstRefresh && state.step % kRefreshEvery == 0)
    if (auto done =
            caster ? caster->refresh(state.step) : refresh_fields(state, learner, source, options.seed);
        !done)
      return done.error();
  return result;
}

}  // namespace likeness
