// Training an avatar: checks, volumes, steps until the budget is spent, checkpoints.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/image/metrics.h"
#include "core/render/backend.h"
#include "core/train/capture_summary.h"
#include "core/train/cast_rays.h"
#include "core/train/check_set.h"
#include "core/train/checkpoint.h"
#include "core/train/condition_map.h"
#include "core/train/landmark_patches.h"
#include "core/train/loose_cells.h"
#include "core/train/refine_track.h"
#include "core/train/register_clips.h"
#include "core/train/still_cells.h"
#include "core/train/torso_hem.h"
#include "core/train/train.h"
#include "core/train/training_step.h"

namespace likeness {
namespace {

constexpr std::uint64_t kSnapshotEvery = 500;
constexpr int kRecoveries = 3;
constexpr double kReportEvery = 0.25;                 // s
constexpr double kRefineShares[] = {0.4, 0.55, 0.7};  // of the steps, when the track is refined
constexpr double kRegisterShare = kFlatShare;  // of the steps, from which further clips are learnt from
constexpr double kProxySteps = 0.5;            // of the steps, after which proxies teach less
static_assert(kRefineShares[0] >= kFlatShare && kRegisterShare >= kFlatShare && kProxySteps >= kFlatShare,
              "a replay would do it sooner");

Result<void> check_options(const TrainOptions& options) {
  if (!(options.losses.landmark_weight >= 0) || !std::isfinite(options.losses.landmark_weight))
    return Error{ErrorCode::bad_input,
                 fmt::format("A landmark loss cannot have the weight {}.", options.losses.landmark_weight),
                 "Give a number that is not negative, e.g. --landmark-loss 0.1.", "training"};
  if (options.losses.landmark_weight > 0 && options.rays.per_step < 4 * kPatchRays)
    return Error{
        ErrorCode::bad_input,
        fmt::format("A quarter of {} rays a step is less than a patch of {}, which the landmark loss needs.",
                    options.rays.per_step, kPatchRays),
        "Train with more rays a step, or without --landmark-loss.", "training"};
  const FieldSizes& sizes = options.fields.sizes;
  const bool sized = std::ranges::all_of(std::array{sizes.head_log2_entries, sizes.torso_log2_entries},
                                         [](int log2) { return log2 >= 10 && log2 <= 22; }) &&
                     std::ranges::all_of(std::array{sizes.head_finest, sizes.torso_finest},
                                         [](int cells) { return cells > 16 && cells <= 4096; }) &&
                     sizes.code_length >= 1 && sizes.code_length <= 16;
  if (!sized)
    return Error{ErrorCode::bad_input,
                 fmt::format("Grids of 2^{} and 2^{} entries, {} and {} cells and codes of {} numbers cannot "
                             "be trained.",
                             sizes.head_log2_entries, sizes.torso_log2_entries, sizes.head_finest,
                             sizes.torso_finest, sizes.code_length),
                 "Give 2^10 to 2^22 entries, 17 to 4096 cells and 1 to 16 numbers.", "training"};
  if (options.rays.per_step >= 1 && (options.schedule.steps > 0 || options.schedule.budget_s > 0)) return {};
  return Error{ErrorCode::bad_input,
               fmt::format("Nothing can be trained with a budget of {} s and {} rays a step.",
                           options.schedule.budget_s, options.rays.per_step),
               "Give a positive budget in seconds, e.g. --budget 300.", "training"};
}

Avatar make_avatar(const TrainingSet& set, const TrainOptions& options, const ConditionMap& map,
                   float warp_cell, const NeckZone& neck, const TrainingState& state) {
  Avatar avatar = capture_avatar(set, map, warp_cell, neck);
  avatar.head = state.head.part;
  if (state.torso) {
    avatar.torso = state.torso->part;
    avatar.torso_modes.hem = find_hem(set, avatar.torso->cube);
    if (avatar.torso_modes.hem) extend_below(*avatar.torso_modes.hem, *avatar.torso);
  }
  avatar.steps = state.step;
  avatar.seed = options.seed;
  avatar.train_seconds = state.seconds;
  return avatar;
}

// The views as seen by the field: fixed except for the corrections of their tracks.
struct Scene {
  const TrainingSet& set;
  const HeadShape& shape;
  const ConditionMap& map;
  const Volumes& volumes;
  const WarpFrame& warp;
  const LandmarkPatches* patches = nullptr;  // null: no landmark loss
  RaySource rays;

  // Rays and conditions of the views as corrected so far.
  void place_views(TrainingState& state) {
    const std::vector<AvatarPose> poses = pictured_poses(set, map, state.corrections);
    rays = {};  // frees the old lattices first, so that there are not two sets at once
    rays = make_ray_source(set, poses, shape, volumes.head.cube,
                           volumes.torso ? &volumes.torso->cube : nullptr, &warp, volumes.neck);
    rays.patches = patches;
    rays.drawn = state.corrections.empty() ? own_views(set).size() : set.views.size();
    follow_schedule(state);
    set_conditions(state, map, poses, set.attributes);
  }
  // Whether the proxies' share now falls at another step than before: when the steps are settled.
  bool follow_schedule(const TrainingState& state) {
    const std::uint64_t total = state.schedule.total_steps,
                        until = total > 0 ? std::uint64_t(kProxySteps * double(total)) : UINT64_MAX;
    return std::exchange(rays.proxies_until, until) != until && !set.proxies.empty();
  }
  bool has_further() const { return own_views(set).size() < set.views.size(); }
  float warp_cell() const { return rays.warps.empty() ? 0.f : warp.cell; }
};

bool fits(const std::vector<Eigen::VectorXd>& corrections, const TrainingSet& set, const ConditionMap& map) {
  return corrections.empty() ||
         (corrections.size() == set.views.size() && corrections.front().size() >= kPoseChange &&
          corrections.front().size() <= kPoseChange + map.rows.rows());
}

// Further clips are learnt from once their heads are registered.
bool registration_due(const TrainingState& state, const Scene& scene) {
  return scene.has_further() && state.corrections.empty() && state.schedule.total_steps > 0 &&
         double(state.step) >= kRegisterShare * double(state.schedule.total_steps);
}

bool refinement_due(const TrainingState& state) {
  return state.refinements < int(std::size(kRefineShares)) && state.schedule.total_steps > 0 &&
         double(state.step) >= kRefineShares[state.refinements] * double(state.schedule.total_steps);
}

// The run itself: clock, reports, checkpoints, recovery.
struct Run {
  const TrainOptions& options;
  const std::filesystem::path& path;
  const std::string& fingerprint;
  const Progress& progress;
  const std::function<void(const TrainStatus&)>& observe;
  const AvatarTap& tap;

  double start = now();
  double earlier = 0;  // seconds of earlier runs
  double passes = 0;   // seconds in corrections of tracks, earlier runs included
  double last_report = 0, last_checkpoint = 0;
  double mean_loss = 0, mean_samples = 0, step_seconds = 0;
  HalfWay half_way;
  StepSeconds step_times;
  // Seconds spent in reports and snapshots, since a listener may hold up the work, and in pauses.
  double held = 0;

  double now() const { return clock_seconds(options.schedule.clock); }
  double elapsed() const { return earlier + now() - start - held; }

  // A budget is for steps: its share before the rate falls is measured, and later passes are not in it.
  double spent() const { return elapsed() - passes; }

  bool finished(const TrainingState& state) const { return is_over(state.schedule, state.step, spent()); }

  Result<void> save(TrainingState& state) {
    state.seconds = elapsed();
    state.pass_seconds = passes;
    last_checkpoint = state.seconds;
    if (path.empty()) return {};
    return write_checkpoint(path, state, fingerprint);
  }

  double share(const TrainingState& state) const {
    return state.schedule.total_steps > 0 ? double(state.step) / double(state.schedule.total_steps)
                                          : spent() / std::max(1e-9, state.schedule.budget_s);
  }

  void report(const TrainingState& state) {
    const double psnr = mean_loss > 0 ? psnr_from_mse(mean_loss) : 0;
    const double reported_at = now();
    const double reached = spent();
    progress.report(share(state), fmt::format("step {}, training PSNR {:.1f} dB", state.step, psnr));
    if (observe)
      observe({state.step, reached, mean_loss, psnr,
               step_seconds > 0 ? options.rays.per_step / step_seconds : 0,
               mean_samples / options.rays.per_step});
    held += now() - reported_at;
    last_report = elapsed();
  }
};

Error diverged(std::uint64_t step) {
  return {ErrorCode::failed,
          fmt::format("Training diverged at step {}: what it computes is no longer finite.", step),
          "Look at the track's overlay: a wrong fit is the usual cause. Otherwise try another --seed.",
          "training"};
}

Avatar avatar_so_far(const Scene& scene, const Run& run, const TrainingState& state) {
  return make_avatar(scene.set, run.options, scene.map, scene.warp_cell(), scene.volumes.neck, state);
}

// One refinement of the track; its views are then placed again.
Result<void> refine(TrainingState& state, Scene& scene, Run& run, std::stop_token stop) {
  run.progress.report(run.share(state), "correcting the track through the field");
  const Avatar avatar = avatar_so_far(scene, run, state);
  const auto rig = make_rig(avatar, scene.set.model);
  if (!rig) return rig.error();
  RefineOptions options;
  options.seed = run.options.seed + std::uint64_t(state.refinements) * scene.set.views.size();
  auto corrections = refine_track(scene.set, avatar, *rig, state.corrections, options, stop);
  if (stop.stop_requested()) return {};  // all or nothing: it is due again when training continues
  state.corrections = std::move(corrections);
  ++state.refinements;
  scene.place_views(state);
  return {};
}

// Views of a further clip begin as far from the code of zero as its faces' colours are from the first clip's,
// each clip in a direction of its own: another light is then distinguished from the first step on, and clips
// in the same light are learnt as the avatar's own.
void start_further_codes(const RaySource& rays, TrainingState& state) {
  constexpr float kEach = 2, kMost = 1;  // per natural logarithm of a channel's gain
  const TrainingSet& set = *rays.set;
  const std::size_t length = state.codes.size() / (2 * pictured(set));
  std::vector<int> clips;
  for (std::size_t v = own_views(set).size(); v < set.views.size() && length > 0; ++v) {
    const int clip = set.views[v].further_clip;
    if (clips.empty() || clips.back() != clip) clips.push_back(clip);
    const std::size_t place = clips.size() - 1;
    const float apart = std::min(kMost, kEach * rays.views[v].gain.array().log().abs().maxCoeff());
    state.codes[v * length + place % length] = place / length % 2 == 0 ? apart : -apart;
  }
}

Result<void> register_further(TrainingState& state, Scene& scene, Run& run, std::stop_token stop) {
  run.progress.report(run.share(state), "placing the heads of the further clips");
  const Avatar avatar = avatar_so_far(scene, run, state);
  const auto rig = make_rig(avatar, scene.set.model);
  if (!rig) return rig.error();
  RegisterOptions options;
  options.seed = run.options.seed;
  auto corrections = register_clips(scene.set, avatar, *rig, options, stop);
  if (stop.stop_requested()) return {};  // as above
  state.corrections = std::move(corrections);
  scene.place_views(state);
  start_further_codes(scene.rays, state);
  return {};
}

// The steps. The backend may hold what was learnt: `fetch` before the state is read, `place` after it was
// changed.
struct Steps {
  TrainingState& state;
  Scene& scene;
  Run& run;
  std::stop_token stop;
  FieldLearner& learner;
  RayCaster* caster;  // null: the processor casts the rays
  TrainingState& snapshot;
  int& recoveries;
  double before = 0;

  Result<void> fetch() {
    if (auto fetched = learner.fetch(); !fetched) return fetched;
    return caster ? caster->fetch_cells(state) : Result<void>();
  }
  Result<void> place() {
    if (auto placed = learner.place(); !placed) return placed;
    return caster ? caster->place_cells(state) : Result<void>();
  }
  Result<void> place_views() { return caster ? caster->place_views(scene.rays) : Result<void>(); }

  // Keeps a snapshot if everything is finite, otherwise goes back to the last one.
  Result<void> take_snapshot() {
    if (auto fetched = fetch(); !fetched) return fetched;
    if (!is_finite(state)) return recover();
    snapshot = state;
    return {};
  }

  Result<void> save() {
    if (run.options.place.fall_back) {
      if (auto taken = take_snapshot(); !taken) return taken;
    } else {
      if (auto fetched = fetch(); !fetched) return fetched;
      if (!is_finite(state))
        if (auto recovered = recover(); !recovered) return recovered;
    }
    return run.save(state);
  }

  // Back to the last snapshot, with half the learning rate.
  Result<void> recover() {
    if (++recoveries > kRecoveries) return diverged(state.step);
    const double scale = 0.5 * state.schedule.rate_scale;
    state = snapshot;
    run.half_way = {};
    state.schedule.rate_scale = scale;
    if (run.options.refine_track || scene.has_further()) {
      scene.place_views(state);
      if (auto placed = place_views(); !placed) return placed;
    }
    return place();
  }

  Result<void> show() {
    if (auto fetched = fetch(); !fetched) return fetched;
    const double look = run.now();
    state.seconds = run.elapsed();
    run.tap.take(avatar_so_far(scene, run, state));
    run.held += run.now() - look;
    before = run.elapsed();  // a snapshot is not a step
    return {};
  }

  Result<void> after_step(const StepResult& result) {
    const double took = run.elapsed() - before, taken = run.step_times.count(took);
    run.held += took - taken;
    const double now = run.elapsed();
    before = now;
    run.step_seconds = run.step_seconds == 0 ? taken : 0.95 * run.step_seconds + 0.05 * taken;
    run.mean_loss = run.mean_loss == 0 ? result.loss : 0.95 * run.mean_loss + 0.05 * result.loss;
    const double samples = double(result.samples);
    run.mean_samples = run.mean_samples == 0 ? samples : 0.95 * run.mean_samples + 0.05 * samples;
    settle(state.schedule, run.half_way, state.step, run.spent(), run.step_seconds);
    if (scene.follow_schedule(state)) {
      if (auto placed = place_views(); !placed) return placed;
      before = run.elapsed();
    }
    if (now - run.last_report >= kReportEvery) run.report(state);
    if (now - run.last_checkpoint >= run.options.schedule.checkpoint_every_s) {
      if (auto saved = save(); !saved) return saved;
      before = run.elapsed();  // nor is writing a file
    }
    if (state.step % kSnapshotEvery == 0) {
      if (auto taken = take_snapshot(); !taken) return taken;
      before = run.elapsed();
    }
    return run.tap.wanted && run.tap.wanted() ? show() : Result<void>();
  }

  void end_pass() {
    const double now = run.elapsed();
    run.passes += now - before;
    before = now;
  }

  // All steps and the work due between them.
  Result<void> take_steps(const StepOptions& options) {
    before = run.elapsed();
    while (!run.finished(state)) {
      if (stop.stop_requested()) {
        if (auto saved = save(); !saved) return saved;
        return cancelled_error();
      }
      if (registration_due(state, scene)) {
        if (auto fetched = fetch(); !fetched) return fetched;
        if (auto done = register_further(state, scene, run, stop); !done) return done;
        if (auto placed = place(); !placed) return placed;
        if (auto placed = place_views(); !placed) return placed;
        end_pass();
        continue;
      }
      if (run.options.refine_track && refinement_due(state)) {
        if (auto fetched = fetch(); !fetched) return fetched;
        if (auto done = refine(state, scene, run, stop); !done) return done;
        if (auto placed = place_views(); !placed) return placed;
        end_pass();
        continue;
      }
      const auto result = training_step(state, learner, scene.rays, options, caster);
      if (!result) return result.error();
      if (!result->finite) {
        if (auto recovered = recover(); !recovered) return recovered;
        continue;
      }
      if (result->samples == 0)
        return Error{ErrorCode::failed, "No training ray meets the head: the head lies outside the pictures.",
                     "Look at the track's overlay; fit the head again.", "training"};
      if (auto done = after_step(*result); !done) return done;
    }
    return {};
  }

  Result<void> take(const StepOptions& options) {
    do {  // repeated if the last steps could not be kept
      if (auto taken = take_steps(options); !taken) return taken;
      run.report(state);
      if (auto saved = save(); !saved) return saved;
    } while (!run.finished(state));
    return {};
  }
};

Result<void> run_steps(TrainingState& state, Scene& scene, Run& run, std::stop_token stop) {
  const StepOptions options{run.options.rays.per_step,     run.options.seed,
                            run.options.fields.use_latent, run.options.rays.use_occupancy,
                            run.options.rays.even_samples, run.options.losses.landmark_weight};
  TrainingState snapshot = state;
  int recoveries = 0;
  std::shared_ptr<Backend> backend =
      run.options.place.backend ? run.options.place.backend : cpu_backend(run.options.place.precision);
  const auto learn = [&]() -> Result<void> {
    auto learner = make_learner(*backend, state, options, scene.set);
    if (!learner) return learner.error();
    const CasterChoice rays = make_ray_caster(**learner, state, scene.rays, options);
    if (!rays.why_not.empty()) run.progress.report(run.share(state), rays.why_not);
    return Steps{state, scene, run, stop, **learner, rays.caster.get(), snapshot, recoveries}.take(options);
  };
  while (true) {
    const Result<void> done = learn();
    if (done || !run.options.place.fall_back || !failed_on_device(done.error())) return done;
    run.progress.report(run.share(state), continuing_on_processor(done.error()));
    state = snapshot;
    run.half_way = {};
    if (run.options.refine_track || scene.has_further()) scene.place_views(state);
    backend = cpu_backend(run.options.place.precision);
  }
}

}  // namespace

Result<Avatar> train_avatar(const TrainingSet& set, const TrainOptions& options,
                            const std::filesystem::path& checkpoint, const Progress& progress,
                            const std::function<void(const TrainStatus&)>& observe, std::stop_token stop,
                            const AvatarTap& tap) {
  if (stop.stop_requested()) return cancelled_error();
  if (auto checked = check_training_set(set); !checked) return checked.error();
  if (auto checked = check_options(options); !checked) return checked.error();
  const std::string fingerprint = checkpoint.empty() ? "" : training_fingerprint(set, options);
  Run run{options, checkpoint, fingerprint, progress, observe, tap};

  const HeadShape shape = shape_head(set.model, set.person);
  std::vector<Articulation> articulations;
  for (const TrainingView& view : set.views) articulations.push_back(view.pose.articulation);
  const ModeParts parts = mode_parts(options.fields.mode);
  ConditionOptions inputs =
      parts.expression && options.fields.use_expression ? ConditionOptions{} : kNoCondition;
  inputs.gaze &= options.fields.use_gaze;
  const ConditionMap map = learn_condition_map(set.model, shape, articulations, inputs);
  Volumes volumes = make_volumes(set, shape);
  if (!options.fields.use_still) volumes.head.still = {};
  for (const AttributeRegion& region : set.attributes)
    clear_region(region, volumes.head.cube, volumes.head.still);
  const auto warp = parts.warp
                        ? make_warp_frame(set.model, shape, typical_articulation(set), kWarpCell, &set.detail)
                        : Result<WarpFrame>(WarpFrame{});
  if (!warp) return warp.error();
  TrainingState state = make_training_state(set, options, map, volumes);
  std::optional<LandmarkPatches> patches;
  if (options.losses.landmark_weight > 0) {
    auto learnt = learn_landmark_patches(set, shape, options.seed);
    if (!learnt) return learnt.error();
    patches = std::move(*learnt);
    progress.report(0, fmt::format("{} of {} landmarks can be measured by their patches", patches->accepted(),
                                   kLandmarkCount - kFirstPatchLandmark));
  }
  Scene scene{set, shape, map, volumes, *warp, patches ? &*patches : nullptr, {}};

  if (!checkpoint.empty()) {
    TrainingState earlier = state;
    const Result<void> read = read_checkpoint(checkpoint, fingerprint, earlier);
    if (read && fits(earlier.corrections, set, map) &&
        resume_schedule(earlier.schedule, earlier.step, earlier.seconds - earlier.pass_seconds,
                        options.schedule.steps, options.schedule.budget_s)) {
      state = std::move(earlier);
      run.earlier = run.last_checkpoint = state.seconds;
      run.passes = state.pass_seconds;
      progress.report(0, fmt::format("continuing at step {}", state.step));
    } else if (!read && read.error().code != ErrorCode::not_found) {
      progress.report(0, "Training starts over. " + read.error().what);
    }
  }
  scene.place_views(state);
  if (auto done = run_steps(state, scene, run, stop); !done) return done.error();
  Avatar avatar = make_avatar(set, options, map, scene.warp_cell(), volumes.neck, state);
  drop_loose_cells(avatar.head, kSolidHead);
  if (avatar.torso) drop_loose_cells(*avatar.torso, kSolidTorso);
  return avatar;
}

}  // namespace likeness
