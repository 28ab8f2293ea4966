// A training, measured at marks on its way and scored at its end: see model_run.h.
#include "core/lab/study/model_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "core/base/energy.h"
#include "core/base/work_clock.h"
#include "core/image/files.h"
#include "core/image/metrics.h"
#include "core/lab/bench/render_study.h"
#include "core/lab/score/frame_score.h"
#include "core/lab/study/landmark_warp.h"
#include "core/papers/baked_avatar.h"
#include "core/papers/train_nerf.h"
#include "core/render/render.h"
#include "core/train/exposure.h"
#include "core/train/field_fit.h"

namespace likeness {
namespace {

constexpr double kMarks[] = {1.0 / 16, 1.0 / 8, 1.0 / 4, 1.0 / 2};  // of the training
constexpr int kOtherSizes[] = {64, 128, 256, 512};                  // px, for models that render quickly
constexpr std::size_t kTimedFrames = 3;

double worked() { return clock_seconds(WorkClock::processor); }

using Paint =
    std::function<Image(const Camera&, const HeldOutFrame&)>;  // premultiplied, as the frame poses it

struct PaintedFrames {
  std::vector<FrameScore> scores;
  std::vector<Image8> pictures;
  double seconds = 0;
  std::optional<double> joules;
  int joule_frames = 0;  // fewer than all when the processor's energy counter has wrapped round
  bool background_known = true;
};

// Fewer if stopped; the caller then discards them.
PaintedFrames paint_frames(const StudyBench& bench, const std::vector<std::size_t>& which, const Paint& paint,
                           const std::stop_token& stop) {
  PaintedFrames out;
  double joules = 0;
  for (const std::size_t i : which) {
    if (stop.stop_requested()) break;
    const HeldOutFrame& frame = bench.clip.held_out[bench.measured[i]];
    const auto before = processor_joules();
    const double start = worked();
    const Image rgba = paint(frame.camera, frame);
    out.seconds += worked() - start;
    const auto after = processor_joules();
    if (before && after && *after >= *before) out.joules = joules += *after - *before, ++out.joule_frames;
    out.background_known &= !frame.plate.empty();
    // Scored as exported: 8 bits.
    out.pictures.push_back(to_bytes(exposed(composite(rgba, frame.plate), frame.exposure)));
    out.scores.push_back(
        score_picture(to_float(frame.truth), to_float(out.pictures.back()), frame.regions, frame.frame));
  }
  return out;
}

double mean_db(std::span<const FrameScore> scores, double FrameScore::*region) {
  double sum = 0;
  int count = 0;
  for (const FrameScore& f : scores)
    if (const double db = psnr_from_mse(f.*region); std::isfinite(db)) sum += db, ++count;
  return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

ModelMark mark_of(std::span<const FrameScore> scores, bool background_known, double seconds,
                  std::uint64_t step) {
  ModelMark mark{.seconds = seconds, .step = step, .psnr_head_db = mean_db(scores, &FrameScore::head_mse)};
  if (background_known) mark.psnr_db = mean_db(scores, &FrameScore::mse);
  return mark;
}

// Processor seconds per picture at each size.
std::vector<SizeCost> time_sizes(const StudyBench& bench, std::vector<int> sizes, const Paint& paint,
                                 const std::stop_token& stop) {
  std::ranges::sort(sizes);
  sizes.erase(std::unique(sizes.begin(), sizes.end()), sizes.end());
  std::vector<SizeCost> costs;
  for (const int size : sizes) {
    const std::vector<std::size_t> chosen = evenly_chosen(bench.measured.size(), kTimedFrames);
    double seconds = 0;
    for (const std::size_t i : chosen) {
      if (stop.stop_requested()) break;
      const HeldOutFrame& frame = bench.clip.held_out[bench.measured[i]];
      const double start = worked();
      (void)paint(resized(frame.camera, size), frame);
      seconds += worked() - start;
    }
    costs.push_back({size, seconds / double(chosen.size())});
  }
  return costs;
}

struct Trained {
  std::uint64_t seed = 0, steps = 0;
  double train_seconds = 0;
};

// The finished model's figures.
Result<ModelScore> score_model(const StudyBench& bench, const ModelSpec& spec, const Paint& paint,
                               const Trained& trained, std::vector<ModelMark> marks,
                               const std::stop_token& stop) {
  const std::vector<std::size_t> every = evenly_chosen(bench.measured.size(), 0);
  PaintedFrames painted = paint_frames(bench, every, paint, stop);
  if (stop.stop_requested()) return cancelled_error();
  const double n = double(every.size());
  ModelScore s{.seed = trained.seed, .steps = trained.steps, .frames = int(every.size())};
  double ssims = 0, gmsds = 0, distances = 0;
  for (std::size_t k = 0; k < every.size(); ++k) {
    const HeldOutFrame& frame = bench.clip.held_out[bench.measured[k]];
    painted.scores[k].landmarks_px = landmark_errors(bench.detector, frame.truth, painted.pictures[k]);
    ssims += ssim(to_float(frame.truth), to_float(painted.pictures[k]));
    gmsds += gmsd(to_float(frame.truth), to_float(painted.pictures[k]));
    if (!bench.perceptual) continue;
    const auto distance = bench.perceptual->distance(frame.truth, painted.pictures[k]);
    if (!distance) return distance.error();
    distances += *distance;
  }
  const std::vector<FrameScore>& scores = painted.scores;
  if (painted.background_known) {
    s.psnr_db = mean_db(scores, &FrameScore::mse);
    s.mse = mean_finite(scores, [](const FrameScore& f) { return f.mse; });
    s.ssim = ssims / n;
    s.gmsd = gmsds / n;
    if (bench.perceptual) s.lpips = distances / n;
  }
  s.psnr_head_db = mean_db(scores, &FrameScore::head_mse);
  s.psnr_person_db = mean_db(scores, &FrameScore::person_mse);
  s.psnr_face_db = mean_db(scores, &FrameScore::face_mse);
  s.face_mse = mean_finite(scores, [](const FrameScore& f) { return f.face_mse; });
  s.landmark_error_px = mean_finite(scores, [](const FrameScore& f) { return f.landmarks_px.inner; });
  s.mouth_error_px = mean_finite(scores, [](const FrameScore& f) { return f.landmarks_px.mouth; });
  s.eyes_error_px = mean_finite(scores, [](const FrameScore& f) { return f.landmarks_px.eyes; });
  s.lost = bench.clip.lost;
  s.frame_seconds = painted.seconds / n;
  if (painted.joules) s.frame_joules = *painted.joules / painted.joule_frames;
  s.train_seconds = trained.train_seconds;
  if (trained.seed != bench.options.first_seed) return s;

  std::vector<FrameScore> marked;
  for (const std::size_t i : bench.marked) marked.push_back(scores[i]);
  s.marks = std::move(marks);
  s.marks.push_back(mark_of(marked, painted.background_known, trained.train_seconds, trained.steps));
  for (const std::size_t i : bench.shown)
    if (const auto written =
            write_image(bench.folder / picture_name(spec, scores[i].frame), painted.pictures[i]);
        !written)
      return written.error();
  return s;
}

// Which marks of a training are due; only the first seed has any.
class MarkPlan {
 public:
  explicit MarkPlan(bool any) : next_(any ? 0 : std::size(kMarks)) {}
  bool is_due(double share) const { return next_ < std::size(kMarks) && share >= kMarks[next_]; }
  void pass(double share) {
    while (is_due(share)) ++next_;
  }

 private:
  std::size_t next_;
};

AvatarPose pose_of(const Avatar& avatar, const HeldOutFrame& frame) {
  AvatarPose pose = frame.pose;
  if (!avatar.attributes.empty()) pose.attributes = frame.amounts;
  return pose;
}

Paint paint_with(const Avatar& avatar, const AvatarRig& rig, const RenderOptions& options) {
  return [&avatar, &rig, options](const Camera& camera, const HeldOutFrame& frame) {
    return render_frame(avatar, camera, pose_avatar(rig, pose_of(avatar, frame)), options).rgba;
  };
}
Paint paint_with(const Avatar& avatar, const AvatarRig& rig) {
  return paint_with(avatar, rig, render_options(RenderQuality::final));
}
Paint paint_with(const NerfAvatar& avatar, const AvatarRig& rig) {
  return [&](const Camera& camera, const HeldOutFrame& frame) {
    return render_nerf(avatar, camera, pose_avatar(rig, frame.pose));
  };
}

// Measures a running training when a mark is due.
template <class Model>
void take_mark(const StudyBench& bench, const Model& model, const Avatar& scene,
               std::vector<ModelMark>& marks, const std::stop_token& stop) {
  const auto rig = make_rig(scene, bench.clip.set.model);
  if (!rig) return;  // the finished model, rigged in the same way, tells it
  const PaintedFrames painted = paint_frames(bench, bench.marked, paint_with(model, *rig), stop);
  marks.push_back(mark_of(painted.scores, painted.background_known, scene.train_seconds, scene.steps));
}

PictureCost cost_of(const StudyBench& bench, std::string name, const Paint& paint, std::uint64_t bytes,
                    const std::stop_token& stop) {
  const PaintedFrames painted = paint_frames(bench, evenly_chosen(bench.measured.size(), 0), paint, stop);
  PictureCost cost{.name = std::move(name), .psnr_head_db = mean_db(painted.scores, &FrameScore::head_mse)};
  if (painted.background_known) cost.psnr_db = mean_db(painted.scores, &FrameScore::mse);
  cost.psnr_face_db = mean_db(painted.scores, &FrameScore::face_mse);
  cost.frame_seconds = painted.seconds / double(painted.scores.size());
  cost.bytes = bytes;
  return cost;
}

std::uint64_t parameters_of(const Avatar& avatar) {
  return avatar.head.field.parameters.size() + (avatar.torso ? avatar.torso->field.parameters.size() : 0);
}

// The same avatar stored, at each number of cells and in both qualities.
Result<void> time_baked(const StudyBench& bench, const Avatar& avatar, const AvatarRig& rig,
                        const TrainingSet& set, std::vector<PictureCost>& costs, const Progress& progress,
                        std::stop_token stop) {
  const std::vector<int>& cells = bench.options.baked_cells;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    BakeOptions options;
    options.head_resolution = cells[k];
    options.torso_resolution = std::max(kVoxelBlock, cells[k] * 3 / 4 / kVoxelBlock * kVoxelBlock);
    options.seed = avatar.seed;
    // After a training of few steps, as in a trial, storing it is as short.
    options.steps = std::min<std::uint64_t>(options.steps, 10 * avatar.steps);
    options.rays = int(std::min<std::uint64_t>(std::uint64_t(options.rays), 1000 * avatar.steps));
    const double part = 1.0 / double(cells.size());
    const auto baked = bake_avatar(avatar, set, options,
                                   progress.stage(double(k) * part, double(k + 1) * part, "stored"), stop);
    if (!baked) return baked.error();
    for (const RenderSetting& setting : quality_ladder()) {
      const Paint paint = [&](const Camera& camera, const HeldOutFrame& frame) {
        return render_baked(*baked, camera, pose_avatar(rig, frame.pose), setting.options).rgba;
      };
      costs.push_back(cost_of(bench, fmt::format("baked, {} cells, {}", cells[k], setting.name), paint,
                              stored_bytes(*baked), stop));
    }
  }
  return {};
}

// Pictures at the settings of the ladder and around them.
std::vector<PictureCost> time_qualities(const StudyBench& bench, const Avatar& avatar, const AvatarRig& rig,
                                        const std::stop_token& stop) {
  std::vector<RenderSetting> settings = quality_ladder();
  settings.push_back({"exact", {}});
  for (const RenderSetting& setting : quality_ladder()) {
    settings.push_back({setting.name + ", one colour per ray", setting.options});
    settings.back().options.deferred = true;
  }
  for (const int samples : {32, 16, 12, 8, 6}) {
    RenderOptions options = render_options(RenderQuality::final);
    options.max_samples = samples;
    settings.push_back({fmt::format("final of {} samples", samples), options});
  }
  for (const int rays : {2500, 5000, 20000}) {
    RenderOptions options = render_options(RenderQuality::preview);
    options.max_rays = rays;
    settings.push_back({fmt::format("preview of {} rays", rays), options});
  }
  std::vector<PictureCost> costs;
  for (const RenderSetting& setting : settings)
    costs.push_back(cost_of(bench, setting.name, paint_with(avatar, rig, setting.options),
                            sizeof(float) * parameters_of(avatar), stop));
  return costs;
}

// Every measured frame's pose and expression fitted to the frozen field, and scored again.
Result<void> score_refit(const StudyBench& bench, const Avatar& avatar, const AvatarRig& rig,
                         ModelScore& score, const std::stop_token& stop) {
  const Paint refitted = [&](const Camera& camera, const HeldOutFrame& frame) {
    const AvatarPose pose = pose_of(avatar, frame);
    const Image8 even = exposed(frame.truth, frame.exposure.cwiseInverse());
    const FieldFit fit =
        fit_to_field(avatar, rig, camera, {&even, &frame.plate, &frame.regions.head}, pose, {}, {});
    return render_frame(avatar, camera, pose_avatar(rig, changed_pose(pose, avatar.condition, fit.change)),
                        render_options(RenderQuality::final))
        .rgba;
  };
  const PaintedFrames painted = paint_frames(bench, evenly_chosen(bench.measured.size(), 0), refitted, stop);
  if (stop.stop_requested()) return cancelled_error();
  if (painted.background_known) score.psnr_refit_db = mean_db(painted.scores, &FrameScore::mse);
  score.psnr_refit_head_db = mean_db(painted.scores, &FrameScore::head_mse);
  score.psnr_refit_face_db = mean_db(painted.scores, &FrameScore::face_mse);
  return {};
}

std::vector<Vec3f> kept_of(const std::vector<Vec3f>& exposures, int every) {
  std::vector<Vec3f> kept;
  for (std::size_t v = 0; v < exposures.size(); v += std::size_t(std::max(1, every)))
    kept.push_back(exposures[v]);
  return kept;
}

// The clip in the light that the rows of the grid learn it in.
TrainingSet evened(const StudyBench& bench, FieldMode mode) {
  TrainingSet set = bench.clip.set;
  if (const auto exposures = chosen_parts(bench, mode).exposures; !exposures.empty())
    even_exposure(exposures, set);
  return set;
}

TrainingSet thinned(const StudyBench& bench, const ModelSpec& spec) {
  const TrainingSet& set = bench.clip.set;
  TrainingSet some = set;
  if (spec.painted || spec.attributes) take_attributes(bench.attributes, some);
  if (spec.keep_every <= 1) return some;
  std::vector<TrainingView> kept;
  for (std::size_t v = 0; v < set.views.size(); v += std::size_t(spec.keep_every))
    kept.push_back(some.views[v]);
  some.views = std::move(kept);
  return some;
}

Result<ModelScore> run_grid(const StudyBench& bench, const ModelSpec& spec, std::uint64_t seed,
                            std::uint64_t steps, const Progress& progress, std::stop_token stop) {
  TrainOptions options;
  TrainingSet set = thinned(bench, spec);
  ChosenParts parts = chosen_parts(bench, spec.mode);
  if (spec.parts != nullptr) spec.parts(parts);
  parts.exposures = kept_of(parts.exposures, spec.keep_every);
  apply_parts(parts, set, options);
  options.schedule.budget_s = spec.share * bench.options.seconds;
  options.schedule.clock = WorkClock::processor;
  options.schedule.steps = steps;
  options.rays.per_step = bench.options.rays;
  options.seed = seed;
  if (spec.change != nullptr) spec.change(options);
  const bool first = seed == bench.options.first_seed;
  MarkPlan plan(first);
  std::vector<ModelMark> marks;
  std::uint64_t step = 0;
  const double start = worked();
  double held = 0, share = 0;
  const AvatarTap tap{[&] {
                        ++step;
                        share = options.schedule.steps > 0
                                    ? double(step) / double(options.schedule.steps)
                                    : (worked() - start - held) / options.schedule.budget_s;
                        return plan.is_due(share);
                      },
                      [&](const Avatar& avatar) {
                        const double look = worked();
                        take_mark(bench, avatar, avatar, marks, stop);
                        plan.pass(share);
                        held += worked() - look;
                      }};
  double samples_per_ray = 0;
  const auto observe = [&](const TrainStatus& status) { samples_per_ray = status.samples_per_ray; };
  auto avatar = train_avatar(set, options, {}, progress, observe, stop, tap);
  if (!avatar) return avatar.error();
  const auto made = make_rig(*avatar, bench.clip.set.model);
  if (!made) return made.error();
  const AvatarRig& rig = *made;
  auto score = score_model(bench, spec, paint_with(*avatar, rig),
                           {avatar->seed, avatar->steps, avatar->train_seconds}, std::move(marks), stop);
  if (!score) return score.error();
  score->parameters = parameters_of(*avatar);
  if (samples_per_ray > 0) score->samples_per_ray = samples_per_ray;
  if (bench.options.refit)
    if (const auto fitted = score_refit(bench, *avatar, rig, *score, stop); !fitted) return fitted.error();
  if (!spec.costs || !first) return score;
  score->qualities = time_qualities(bench, *avatar, rig, stop);
  if (const auto stored = time_baked(bench, *avatar, rig, set, score->qualities, progress, stop); !stored)
    return stored.error();
  std::vector<int> sizes(std::begin(kOtherSizes), std::end(kOtherSizes));
  sizes.push_back(bench.clip.set.size), sizes.push_back(bench.full_size);
  score->sizes = time_sizes(bench, std::move(sizes), paint_with(*avatar, rig), stop);
  if (stop.stop_requested()) return cancelled_error();
  return score;
}

Result<ModelScore> run_mlp(const StudyBench& bench, const ModelSpec& spec, std::uint64_t seed,
                           std::uint64_t steps, const Progress& progress, std::stop_token stop) {
  NerfOptions options;
  options.mode = spec.mode;
  options.budget_s = spec.share * bench.options.seconds;
  options.clock = WorkClock::processor;
  options.steps = steps;
  options.seed = seed;
  const bool first = seed == bench.options.first_seed;
  MarkPlan plan(first);
  std::vector<ModelMark> marks;
  const auto share = [&](const TrainStatus& status) {
    return options.steps > 0 ? double(status.step) / double(options.steps)
                             : status.seconds / options.budget_s;
  };
  const NerfTap tap{[&](const TrainStatus& status) { return plan.is_due(share(status)); },
                    [&](const NerfAvatar& avatar, const TrainStatus& status) {
                      take_mark(bench, avatar, avatar.scene, marks, stop);
                      plan.pass(share(status));
                    }};
  const auto avatar = train_nerf(evened(bench, spec.mode), options, progress, stop, tap);
  if (!avatar) return avatar.error();
  const auto made = make_rig(avatar->scene, bench.clip.set.model);
  if (!made) return made.error();
  const AvatarRig& rig = *made;
  const Avatar& scene = avatar->scene;
  auto score = score_model(bench, spec, paint_with(*avatar, rig),
                           {scene.seed, scene.steps, scene.train_seconds}, std::move(marks), stop);
  if (!score) return score.error();
  score->parameters = parameter_count(*avatar);
  if (spec.costs && first)
    score->sizes = time_sizes(bench, {bench.clip.set.size, bench.full_size}, paint_with(*avatar, rig), stop);
  if (stop.stop_requested()) return cancelled_error();
  return score;
}

Result<ModelScore> run_moved(const StudyBench& bench, const ModelSpec& spec, std::uint64_t seed,
                             std::stop_token stop) {
  if (stop.stop_requested()) return cancelled_error();
  const double start = worked();
  const LandmarkWarp warp = make_landmark_warp(evened(bench, kDefaultMode));
  const Paint paint = [&](const Camera& camera, const HeldOutFrame& frame) {
    return render_landmark_warp(warp, bench.clip.set.model, camera, frame.pose);
  };
  return score_model(bench, spec, paint, {seed, 0, worked() - start}, {}, stop);
}

}  // namespace

std::string picture_name(const ModelSpec& spec, int frame) {
  return fmt::format("{}-{:06}.png", spec.name, frame);
}

ChosenParts chosen_parts(const StudyBench& bench, FieldMode mode) {
  const TrainingSet& set = bench.clip.set;
  AskedParts asked;
  if (mode != kDefaultMode) asked.mode = mode;
  return choose_parts(measure_capture(set, shape_head(set.model, set.person)), asked);
}

Result<ModelScore> run_model(const StudyBench& bench, const ModelSpec& spec, std::uint64_t seed,
                             std::uint64_t steps, const Progress& progress, std::stop_token stop) {
  switch (spec.kind) {
    case ModelKind::grid:
      return run_grid(bench, spec, seed, steps, progress, stop);
    case ModelKind::mlp:
      return run_mlp(bench, spec, seed, steps, progress, stop);
    case ModelKind::moved:
      break;
  }
  return run_moved(bench, spec, seed, stop);
}

}  // namespace likeness
