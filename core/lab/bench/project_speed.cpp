// See project_speed.h.
#include "core/lab/bench/project_speed.h"

#include <algorithm>
#include <filesystem>

#include "core/base/files.h"
#include "core/base/temporary_folder.h"
#include "core/lab/bench/render_study.h"
#include "core/project/project_head_model.h"
#include "core/project/stage_inputs.h"
#include "core/project/training_options.h"
#include "core/project/training_set.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// The rate from the first report to the last, so that neither reading nor writing counts.
struct Pace {
  std::uint64_t first_step = 0, last_step = 0;
  double first_s = 0, last_s = 0;
  void add(const TrainStatus& status) {
    if (first_step == 0) first_step = status.step, first_s = status.seconds;
    last_step = status.step, last_s = status.seconds;
  }
  double steps_per_s() const {
    return last_s > first_s ? double(last_step - first_step) / (last_s - first_s) : 0;
  }
};

Result<double> training_rays_per_s(const Project& project, const ProjectSpeedOptions& options,
                                   const Progress& progress, std::stop_token stop) {
  const auto model = project_head_model(project.options);
  if (!model) return model.error();
  auto set = load_training_set(project, *model);
  if (!set) return set.error();
  const auto scratch = TemporaryFolder::make("speed");
  if (!scratch) return scratch.error();
  const fs::path checkpoint = scratch->path() / "checkpoint.bin";
  TrainOptions training = training_options(stage_inputs(project.options).train);
  (void)take_parts(project, *set, training);
  training.place.precision = options.precision;
  training.place.backend = options.backend;
  training.schedule.steps = 0;
  training.schedule.budget_s = options.train_seconds;
  std::error_code failure;
  if (fs::exists(checkpoint_path(project), failure)) {
    if (!fs::copy_file(checkpoint_path(project), checkpoint, failure))
      return file_error(checkpoint, "write", failure.value());
    const auto avatar = read_avatar(avatar_path(project));
    if (!avatar) return avatar.error();
    training.schedule.budget_s += avatar->train_seconds;
  }
  Pace pace;
  const auto trained = train_avatar(
      *set, training, checkpoint, progress, [&](const TrainStatus& status) { pace.add(status); }, stop);
  if (!trained) return trained.error();
  return double(training.rays.per_step) * pace.steps_per_s();
}

}  // namespace

Result<ProjectSpeed> measure_project_speed(const Project& project, const ProjectSpeedOptions& options,
                                           const Progress& progress, std::stop_token stop) {
  const auto pictures = study_rendering(project, options.frames, quality_ladder(), options.backend,
                                        progress.stage(0, 0.4, "pictures"), stop);
  if (!pictures) return pictures.error();
  const RenderRow &best = pictures->rows[0], &quick = pictures->rows[1];
  ProjectSpeed speed{.size = pictures->size,
                     .frames = pictures->frames,
                     .backend = options.backend ? options.backend->name() : "cpu",
                     .final_fps = best.frames_per_second,
                     .preview_fps = quick.frames_per_second,
                     .final_ms = best.milliseconds,
                     .preview_ms = quick.milliseconds,
                     .preview_loss_head_db = best.psnr_head_db - quick.psnr_head_db};
  if (best.psnr_db && quick.psnr_db) speed.preview_loss_db = *best.psnr_db - *quick.psnr_db;
  const auto rays = training_rays_per_s(project, options, progress.stage(0.4, 1, "training"), stop);
  if (!rays) return rays.error();
  speed.rays_per_s = *rays;
  progress.report(1);
  return speed;
}

}  // namespace likeness
