// One training step.
#include "core/train/training_step.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/render/canonical_samples.h"
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
constexpr float kCodePenalty = 1e-4f;   // weight of the codes' mean square in the loss

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

Result<std::unique_ptr<FieldLearner>> make_learner(Backend& backend, TrainingState& state,
                                                   const StepOptions& options, const TrainingSet& set) {
  LearntParts parts;
  parts.fields[0] = {&state.head.part.field, &state.head.adam};
  if (state.torso) parts.fields[1] = {&state.torso->part.field, &state.torso->adam};
  parts.codes = &state.codes, parts.codes_adam = &state.codes_adam;
  return backend.make_learner(parts, {std::size_t(options.rays), std::size_t(kTrainingSamples), pictured(set),
                                      own_views(set).size(), options.landmark_weight > 0});
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
