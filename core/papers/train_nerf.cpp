// Training the baselines: see train_nerf.h.
#include "core/papers/train_nerf.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/parallel.h"
#include "core/field/adam.h"
#include "core/image/metrics.h"
#include "core/render/canonical_samples.h"
#include "core/train/capture_summary.h"
#include "core/train/check_set.h"
#include "core/train/condition_map.h"
#include "core/train/random_stream.h"
#include "core/train/ray_batch.h"
#include "core/train/refine_track.h"
#include "core/train/schedule.h"
#include "core/train/volumes.h"

namespace likeness {
namespace {

constexpr std::uint64_t kTimedSteps = 10;  // before a budget becomes a number of steps: the first are slow

FieldPart empty_part(const Volume& volume) {
  FieldPart part;
  part.cube = volume.cube;
  part.occupancy = volume.allowed;
  part.core = volume.core;
  return part;
}

// What one field's two passes are trained with.
struct PairTraining {
  NerfPair* fields = nullptr;
  std::array<ArrayAdamState, 2> adam;
  std::array<std::vector<float>, 2> gradients;
};

struct Training {
  const NerfOptions& options;
  RaySource rays;
  std::vector<float> conditions;  // (views, K)
  NerfAvatar avatar;
  std::array<PairTraining, 2> parts;  // head, torso
  Schedule schedule;
  std::uint64_t step = 0;
  // Scratch.
  RayBatch batch;
  std::array<NerfPass, 2> passes;
};

// Summed squared error of a pass and the slopes of `scale` times it.
struct PassLoss {
  double error = 0;
  std::array<std::vector<float>, 2> d_sigma, d_colour;  // by field: (N), (N, 3)
};

PassLoss loss_of(const NerfPass& pass, const RayBatch& rays, float scale) {
  PassLoss loss;
  for (std::size_t f = 0; f < 2; ++f)
    loss.d_sigma[f].resize(pass.sigma[f].size()), loss.d_colour[f].resize(pass.colour[f].size());
  std::vector<float> sigma, colour, d_sigma, d_colour;
  for (std::size_t r = 0; r < pass.rays.size(); ++r) {
    const std::uint32_t first = pass.batch.begin[r];
    const std::size_t n = pass.batch.begin[r + 1] - first;
    sigma.resize(n), colour.resize(3 * n), d_sigma.resize(n), d_colour.resize(3 * n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t f = pass.batch.field[first + i], at = pass.batch.slot[first + i];
      sigma[i] = pass.sigma[f][at];
      std::copy_n(pass.colour[f].data() + 3 * at, 3, colour.data() + 3 * i);
    }
    float d_pixel[3];
    for (int c = 0; c < 3; ++c) {
      const float difference =
          pass.rays[r].colour[c] + pass.rays[r].transmittance * rays.background[r][c] - rays.target[r][c];
      loss.error += double(difference) * difference;
      d_pixel[c] = 2 * scale * difference;
    }
    composite_ray_backward(int(n), sigma.data(), pass.batch.dt.data() + first, colour.data(),
                           rays.background[r].data(), pass.rays[r], d_pixel, 0.f, d_sigma.data(),
                           d_colour.data());
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t f = pass.batch.field[first + i], at = pass.batch.slot[first + i];
      loss.d_sigma[f][at] = d_sigma[i];
      std::copy_n(d_colour.data() + 3 * i, 3, loss.d_colour[f].data() + 3 * at);
    }
  }
  return loss;
}

// Gradients of a field: of its chunks one by one, added in their order.
void backward(const NerfField<float>& field, const NerfPass& pass, const PassLoss& loss, std::size_t part,
              std::vector<float>& gradients) {
  const std::size_t n = pass.sigma[part].size(), chunks = pass.tapes[part].size();
  gradients.assign(field.parameters.size(), 0.f);
  std::vector<std::vector<float>> partial(chunks);
  parallel_for(chunks, [&](std::size_t k) {
    const std::size_t begin = k * kNerfChunk, count = std::min(kNerfChunk, n - begin);
    const auto columns = Eigen::Index(count);
    using Given = Eigen::Map<const DenseMatrix<float>>;
    const NerfOutputs<float> outputs{Given(pass.sigma[part].data() + begin, 1, columns),
                                     Given(pass.colour[part].data() + 3 * begin, 3, columns)};
    const NerfOutputs<float> slopes{Given(loss.d_sigma[part].data() + begin, 1, columns),
                                    Given(loss.d_colour[part].data() + 3 * begin, 3, columns)};
    partial[k].assign(gradients.size(), 0.f);
    nerf_backward(field, pass.tapes[part][k], outputs, slopes, partial[k]);
  });
  parallel_ranges(gradients.size(), 16384, [&](std::size_t begin, std::size_t end) {
    for (const std::vector<float>& some : partial)
      for (std::size_t i = begin; i < end; ++i) gradients[i] += some[i];
  });
}

// Mean squared error of the fine pass before the step; NaN changes nothing.
double training_step(Training& t) {
  const Avatar& scene = t.avatar.scene;
  NerfScene rays{&t.avatar.head, t.avatar.torso ? &*t.avatar.torso : nullptr, {}, t.conditions.data(), {}};
  rays.volumes = march_volumes(scene.head, scene.torso ? &*scene.torso : nullptr, t.rays.necks);
  rays.to_canonical = [&](SampleBatch& batch) {
    warp_samples(t.rays.warps, scene.head.cube, batch.fields[0]);
    straighten_samples(t.rays.necks, batch.fields[0]);
    if (scene.torso) warp_samples(t.rays.torsos, scene.torso->cube, batch.fields[1]);
  };
  choose_rays(t.rays, rays.volumes, false, t.options.seed, t.step, t.options.rays_per_step, t.batch);
  NerfMarchOptions march = t.options.march;
  march.seed = RandomStream(t.options.seed, t.step, 0x6d617263).bits() | 1;
  march_nerf(rays, t.batch.requests, march, true, t.passes);

  const float scale = 1.f / (3 * float(t.batch.requests.size()));
  const std::array<PassLoss, 2> losses{loss_of(t.passes[0], t.batch, scale),
                                       loss_of(t.passes[1], t.batch, scale)};
  if (!std::isfinite(losses[0].error + losses[1].error)) return std::nan("");
  AdamOptions adam;
  adam.beta2 = 0.999f, adam.network_epsilon = 1e-8f;
  const auto rate = float(t.options.rate * learning_rate(t.step, t.schedule));
  for (std::size_t f = 0; f < 2; ++f) {
    PairTraining& part = t.parts[f];
    if (part.fields == nullptr) continue;
    for (std::size_t p = 0; p < 2; ++p) {
      if (t.passes[p].sigma[f].empty()) continue;
      backward((*part.fields)[p], t.passes[p], losses[p], f, part.gradients[p]);
      adam_step((*part.fields)[p].parameters, part.gradients[p], part.adam[p], rate, adam);
    }
  }
  ++t.step;
  return losses[1].error * double(scale);
}

NerfPair make_pair_of(const NerfConfig& config, std::uint64_t seed) {
  return {make_nerf_field(config, 2 * seed), make_nerf_field(config, 2 * seed + 1)};
}

std::vector<float> conditions_of(const ConditionMap& map, std::span<const AvatarPose> poses) {
  std::vector<float> all;
  for (const AvatarPose& pose : poses) {
    const Eigen::VectorXf psi = condition(map, pose.articulation);
    all.insert(all.end(), psi.begin(), psi.end());
  }
  return all;
}

// Steps until the budget or the requested number; the clock stops while the tap is called. start: the
// clock's, preparations included, as in core/train.
Result<void> run(Training& t, double start, const Progress& progress, std::stop_token stop,
                 const NerfTap& tap) {
  const auto clock = [&] { return clock_seconds(t.options.clock); };
  double held = 0, mean_loss = 0, step_seconds = 0, before = clock() - start;
  HalfWay half_way;
  while (!is_over(t.schedule, t.step, before)) {
    if (stop.stop_requested()) return cancelled_error();
    const double loss = training_step(t);
    if (!std::isfinite(loss))
      return Error{ErrorCode::failed,
                   fmt::format("The baseline diverged at step {}: the loss is not a finite number.", t.step),
                   "Try another --seed.", "training a baseline"};
    const double now = clock() - start - held;
    step_seconds = step_seconds == 0 ? now - before : 0.9 * step_seconds + 0.1 * (now - before);
    mean_loss = mean_loss == 0 ? loss : 0.95 * mean_loss + 0.05 * loss;
    before = now;
    if (t.step >= kTimedSteps) settle(t.schedule, half_way, t.step, now, step_seconds);
    const TrainStatus status{t.step, now, mean_loss, psnr_from_mse(mean_loss),
                             t.options.rays_per_step / std::max(step_seconds, 1e-9)};
    t.avatar.scene.steps = t.step, t.avatar.scene.train_seconds = now;
    const double share = t.schedule.total_steps > 0 ? double(t.step) / double(t.schedule.total_steps)
                                                    : now / t.schedule.budget_s;
    progress.report(std::min(share, 1.0),
                    fmt::format("step {}, training PSNR {:.1f} dB", t.step, status.train_psnr_db));
    if (tap.wanted && tap.wanted(status)) {
      const double look = clock();
      tap.take(t.avatar, status);
      held += clock() - look;
    }
  }
  return {};
}

}  // namespace

Result<NerfAvatar> train_nerf(const TrainingSet& set, const NerfOptions& options, const Progress& progress,
                              std::stop_token stop, const NerfTap& tap) {
  if (stop.stop_requested()) return cancelled_error();
  if (auto checked = check_training_set(set); !checked) return checked.error();
  const double start = clock_seconds(options.clock);
  const ModeParts mode = mode_parts(options.mode);
  const HeadShape shape = shape_head(set.model, set.person);
  std::vector<Articulation> articulations;
  for (const TrainingView& view : set.views) articulations.push_back(view.pose.articulation);
  const ConditionMap map = learn_condition_map(set.model, shape, articulations,
                                               mode.expression ? ConditionOptions{} : kNoCondition);
  const Volumes volumes = make_volumes(set, shape);
  const auto made = mode.warp
                        ? make_warp_frame(set.model, shape, typical_articulation(set), kWarpCell, &set.detail)
                        : Result<WarpFrame>(WarpFrame{});
  if (!made) return made.error();
  const WarpFrame& warp = *made;
  const std::vector<AvatarPose> poses = corrected_poses(set, map, {});

  Training t{.options = options};
  t.rays = make_ray_source(set, poses, shape, volumes.head.cube,
                           volumes.torso ? &volumes.torso->cube : nullptr, &warp, volumes.neck);
  t.conditions = conditions_of(map, poses);
  t.avatar.scene = capture_avatar(set, map, t.rays.warps.empty() ? 0.f : warp.cell, volumes.neck);
  t.avatar.scene.seed = options.seed;
  t.avatar.scene.head = empty_part(volumes.head);
  NerfConfig head = options.head;
  head.condition_count = int(map.rows.rows());
  head.slice = mode.ambient;
  t.avatar.head = make_pair_of(head, 2 * options.seed);
  t.parts[0].fields = &t.avatar.head;
  if (volumes.torso) {
    t.avatar.scene.torso = empty_part(*volumes.torso);
    t.avatar.torso = make_pair_of(options.torso, 2 * options.seed + 1);
    t.parts[1].fields = &*t.avatar.torso;
  }
  t.schedule.total_steps = options.steps;
  t.schedule.budget_s = options.steps > 0 ? 0 : options.budget_s;
  if (auto done = run(t, start, progress, stop, tap); !done) return done.error();
  return std::move(t.avatar);
}

}  // namespace likeness
