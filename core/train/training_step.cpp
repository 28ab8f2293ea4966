// One training step.
#include "core/train/training_step.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/parallel.h"
#include "core/render/composite.h"
#include "core/render/pose_avatar.h"
#include "core/train/random_stream.h"
#include "core/train/refine_track.h"
#include "core/train/still_cells.h"

namespace likeness {
namespace {

constexpr int kMaxSamples = 16, kCodeLength = 4;
constexpr std::uint64_t kFirstRefresh = 128, kRefreshEvery = 32;
constexpr float kTableRate = 1e-2f, kNetworkRate = 3e-3f, kCodeRate = 1e-3f;
constexpr float kConditionBlur = 0.2f;  // largest shift of psi, in deviations of each component
constexpr float kInitialDensity = 4;    // per cube side: a haze, so that the first gradients see every depth
constexpr float kCodePenalty = 1e-4f;   // weight of the codes' mean square in the loss

FieldConfig head_config(int conditions, const TrainOptions& options) {
  FieldConfig config;
  config.initial_density = kInitialDensity;
  config.position = {3, 8, 4, 16, 16, 512};
  config.condition_count = conditions;
  config.ambient = mode_parts(options.mode).ambient;
  config.ambient_grid = {2, 8, 4, 14, 8, 64};
  config.density_layers = 1;
  config.latent_count = options.use_latent ? kCodeLength : 0;
  return config;
}

FieldConfig torso_config() {
  FieldConfig config;
  config.initial_density = kInitialDensity;
  config.position = {3, 8, 4, 15, 16, 384};
  config.density_width = 32, config.density_layers = 1;
  config.colour_width = 32, config.colour_layers = 1;
  config.view_direction = false;
  return config;
}

TrainedField make_trained_field(const FieldConfig& config, const Volume& volume, std::uint32_t seed,
                                std::size_t views) {
  TrainedField field;
  field.volume = volume;
  field.part.field = make_field(config, seed);
  field.part.cube = volume.cube;
  field.part.occupancy = volume.allowed;
  field.part.core = volume.core;
  field.adam = make_adam_state(field.part.field);
  field.learnt = make_occupancy_state(volume);
  field.tape = make_tape();
  field.gradients = make_gradients(field.part.field, 2 * views);
  return field;
}

// Forward and backward compositing of rays [begin, end); returns their summed squared error.
struct RayLoss {
  const RayBatch& rays;
  const SampleBatch& samples;
  std::array<TrainedField*, 2> fields;
  float scale = 1;  // of the loss: 1 / (rays * channels)

  double operator()(std::size_t begin, std::size_t end) const {
    float sigma[kMaxSamples], colour[3 * kMaxSamples], d_sigma[kMaxSamples], d_colour[3 * kMaxSamples];
    double error = 0;
    for (std::size_t r = begin; r < end; ++r) {
      const std::uint32_t first = samples.begin[r];
      const int n = int(samples.begin[r + 1] - first);
      for (int i = 0; i < n; ++i) {
        const FieldOutputs& out = fields[samples.field[first + i]]->outputs;
        const std::uint32_t at = samples.slot[first + i];
        sigma[i] = out.sigma[at];
        colour[3 * i] = out.red[at], colour[3 * i + 1] = out.green[at], colour[3 * i + 2] = out.blue[at];
      }
      const Composited<float> seen = composite_ray(n, sigma, samples.dt.data() + first, colour);
      float d_pixel[3];
      for (int c = 0; c < 3; ++c) {
        const float difference =
            seen.colour[c] + seen.transmittance * rays.background[r][c] - rays.target[r][c];
        error += double(difference) * difference;
        d_pixel[c] = 2 * scale * difference;
      }
      composite_ray_backward(n, sigma, samples.dt.data() + first, colour, rays.background[r].data(), seen,
                             d_pixel, 0.f, d_sigma, d_colour);
      for (int i = 0; i < n; ++i) {
        TrainedField& field = *fields[samples.field[first + i]];
        const std::uint32_t at = samples.slot[first + i];
        field.d_sigma[at] = d_sigma[i];
        field.d_red[at] = d_colour[3 * i], field.d_green[at] = d_colour[3 * i + 1];
        field.d_blue[at] = d_colour[3 * i + 2];
      }
    }
    return error;
  }
};

void resize_gradients(TrainedField& field, std::size_t count) {
  for (auto* v : {&field.d_sigma, &field.d_red, &field.d_green, &field.d_blue}) v->resize(count);
}

void update_codes(TrainingState& state, FieldGradients& gradients, std::size_t views,
                  const AdamOptions& options) {
  const std::size_t length = views == 0 ? 0 : state.codes.size() / (2 * views);
  const std::size_t half = views * length;
  if (half == 0) return;
  std::vector<float> codes(state.codes.begin(), state.codes.begin() + std::ptrdiff_t(half));
  std::vector<float> slope(gradients.latents.begin(), gradients.latents.begin() + std::ptrdiff_t(half));
  for (std::size_t i = 0; i < half; ++i) slope[i] += 2 * kCodePenalty * codes[i] / float(half);
  const float rate = kCodeRate * options.network_rate / kNetworkRate;
  adam_step(codes, slope, state.codes_adam, rate, options);
  for (std::size_t l = 0; l < length; ++l) {  // zero mean over the views
    double mean = 0;
    for (std::size_t v = 0; v < views; ++v) mean += codes[v * length + l];
    mean /= double(views);
    for (std::size_t v = 0; v < views; ++v) codes[v * length + l] -= float(mean);
  }
  std::copy(codes.begin(), codes.end(), state.codes.begin());
  std::fill(gradients.latents.begin(), gradients.latents.end(), 0.f);
}

void refresh(TrainedField& field, const TrainingState& state, std::size_t views,
             const std::function<void(FieldSamples&)>& to_canonical, std::uint64_t seed) {
  refresh_occupancy(field.learnt, field.part, state.conditions.data(), views, to_canonical, seed, state.step);
  field.part.occupancy = occupancy_bits(field.learnt, field.volume);
  field.part.opacity = cell_opacities(field.learnt, field.volume);
}

// Rays without a code also see their expression a little off, so that the slice is smooth between the frames.
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

TrainingState make_training_state(const TrainingSet& set, const TrainOptions& options,
                                  const ConditionMap& map, const Volumes& volumes) {
  TrainingState state;
  const std::size_t views = set.views.size();
  const int k = int(map.rows.rows());
  const auto seed = std::uint32_t(options.seed * 2);
  state.head = make_trained_field(head_config(k, options), volumes.head, seed, views);
  if (volumes.torso) state.torso = make_trained_field(torso_config(), *volumes.torso, seed + 1, views);
  const std::size_t length = std::size_t(state.head.part.field.config.latent_count);
  state.codes.assign(2 * views * length, 0.f);
  set_conditions(state, map, corrected_poses(set, map, {}));
  state.schedule.total_steps = options.steps;
  state.schedule.rate_scale = options.rate;
  state.schedule.budget_s = options.steps > 0 ? 0 : options.budget_s;
  return state;
}

void set_conditions(TrainingState& state, const ConditionMap& map, std::span<const AvatarPose> poses) {
  const std::size_t views = poses.size(), k = std::size_t(map.rows.rows());
  state.conditions.resize(2 * views * k);
  for (std::size_t v = 0; v < views; ++v) {
    const Eigen::VectorXf psi = condition(map, poses[v].articulation);
    for (const std::size_t row : {v, v + views})
      std::copy(psi.begin(), psi.end(), state.conditions.begin() + std::ptrdiff_t(row * k));
  }
  state.deviations.assign(k, 0.f);
  for (std::size_t i = 0; i < views * k; ++i)
    state.deviations[i % k] += state.conditions[i] * state.conditions[i] / float(views);
  for (float& deviation : state.deviations) deviation = std::sqrt(deviation);
}

StepResult training_step(TrainingState& state, const RaySource& source, const StepOptions& options) {
  const std::size_t views = source.views.size();
  std::array<TrainedField*, 2> fields = {&state.head, state.torso ? &*state.torso : nullptr};

  // -- Rays and their samples.
  blur_conditions(state, views, options.seed);
  MarchVolumes volumes =
      march_volumes(state.head.part, state.torso ? &state.torso->part : nullptr, source.necks);
  volumes.max_samples = kMaxSamples;
  choose_rays(source, volumes, options.use_latent, options.seed, state.step, options.rays, state.rays);
  sample_rays(state.rays.requests, volumes, state.samples);
  warp_samples(source.warps, state.head.part.cube, state.samples.fields[0]);
  straighten_samples(source.necks, state.samples.fields[0]);
  shuffle_conditions(state.head.volume.still, views, options.seed, state.step, state.samples.fields[0]);
  if (state.torso) warp_samples(source.torsos, state.torso->part.cube, state.samples.fields[1]);

  // -- Forward.
  const float* codes = state.codes.empty() ? nullptr : state.codes.data();
  std::array<FieldInputs, 2> inputs;
  StepResult result;
  for (int f = 0; f < 2; ++f) {
    const FieldSamples& samples = state.samples.fields[f];
    if (!fields[f] || samples.count() == 0) continue;
    inputs[f] = samples.inputs(state.conditions.data(), f == 0 ? codes : nullptr);
    forward_field(fields[f]->part.field, inputs[f], fields[f]->outputs, *fields[f]->tape);
    resize_gradients(*fields[f], samples.count());
    result.samples += samples.count();
  }

  // -- Loss, in fixed chunks so that its sum does not depend on the threads.
  constexpr std::size_t kChunk = 256;
  const std::size_t rays = state.rays.requests.size();
  const RayLoss loss{state.rays, state.samples, fields, 1.f / (3 * float(rays))};
  std::vector<double> errors((rays + kChunk - 1) / kChunk);
  parallel_ranges(rays, kChunk,
                  [&](std::size_t begin, std::size_t end) { errors[begin / kChunk] = loss(begin, end); });
  for (const double error : errors) result.loss += error;
  result.loss /= 3 * double(rays);
  if (!std::isfinite(result.loss)) {
    result.finite = false;
    return result;
  }

  // -- Backward and Adam.
  const double rate = learning_rate(state.step, state.schedule);
  AdamOptions adam;
  adam.table_rate = float(kTableRate * rate), adam.network_rate = float(kNetworkRate * rate);
  for (int f = 0; f < 2; ++f) {
    if (!fields[f] || inputs[f].count == 0) continue;
    TrainedField& field = *fields[f];
    const FieldOutputGradients slopes{field.d_sigma.data(), field.d_red.data(), field.d_green.data(),
                                      field.d_blue.data()};
    backward_field(field.part.field, inputs[f], slopes, *field.tape, field.gradients);
    adam_step(field.part.field, field.gradients, field.adam, adam);
  }
  if (options.use_latent && inputs[0].count > 0) update_codes(state, state.head.gradients, views, adam);
  ++state.step;

  // -- Occupancy.
  if (options.use_occupancy && state.step >= kFirstRefresh && state.step % kRefreshEvery == 0) {
    const auto head_to_canonical = [&](FieldSamples& samples) {
      warp_samples(source.warps, state.head.part.cube, samples);
      straighten_samples(source.necks, samples);
    };
    refresh(state.head, state, views, head_to_canonical, options.seed);
    if (state.torso)
      refresh(
          *state.torso, state, views,
          [&](FieldSamples& samples) { warp_samples(source.torsos, state.torso->part.cube, samples); },
          options.seed);
  }
  return result;
}

}  // namespace likeness
