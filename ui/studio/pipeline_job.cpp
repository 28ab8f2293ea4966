// See pipeline_job.h.
#include "ui/studio/pipeline_job.h"

#include <algorithm>
#include <utility>

namespace likeness::ui {

PipelineJob::PipelineJob(Project project, Stage last, bool previews, std::function<void()> wake,
                         std::shared_future<void> written, ComputePlace place)
    : project_(std::move(project)), last_(last), place_(std::move(place)) {
  status_.records = project_.stages;
  if (previews && last == Stage::train)
    preview_ = std::make_unique<TrainingPreview>(project_, wake, place_.open);
  job_ = std::make_unique<Job>(
      [this, written = std::move(written)](const Progress& progress,
                                           std::stop_token stop) -> Result<std::string> {
        made_.wait();
        written.wait();
        Project working = project_;
        RunObserver observer;
        TrainingPlace place;
        observer.stage_changed = [this](Stage s, const StageRecord& record) { stage_changed(s, record); };
        observer.further_changed = [this](Stage s, int, const Project& clip) {
          further_changed(s, clip.record(s).state);
        };
        observer.training = [this](const TrainStatus& status) { trained(status); };
        observer.parts = [this](const std::vector<AvatarPart>& parts) {
          const std::lock_guard lock(mutex_);
          status_.parts = parts;
        };
        if (preview_) observer.tap = preview_->tap();
        if (place_.open && last_ == Stage::train) {
          auto opened = place_.open();
          if (!opened && !place_.fall_back) return opened.error();
          if (opened)
            place.backend = std::move(*opened);
          else
            progress.report(0, continuing_on_processor(opened.error()));
          place.fall_back = place_.fall_back;
        }
        if (auto earlier = read_training_curve(training_curve_path(working))) {
          const std::lock_guard lock(mutex_);
          status_.curve = std::move(*earlier);
        }
        const auto outcome = run_stages(working, last_, progress, observer, stop, place);
        keep_scores();
        if (!outcome) return outcome.error();
        return working.record(last_).message;
      },
      wake);
  made_.count_down();
}

void PipelineJob::stage_changed(Stage stage, const StageRecord& record) {
  const std::lock_guard lock(mutex_);
  status_.records[std::size_t(stage)] = record;
  status_.finished[std::size_t(stage)] = record.state == StageState::done;
  if (record.state == StageState::running) {
    status_.stage = stage;
    worked_before_stage_s_ = job_->status().seconds;
  } else if (status_.stage == stage) {
    status_.stage.reset();
  }
}

// A stage counts as running as long as it runs for any clip.
void PipelineJob::further_changed(Stage stage, StageState state) {
  const std::lock_guard lock(mutex_);
  const bool running = state == StageState::running;
  if (state == StageState::failed) status_.failed = stage;
  status_.finished[std::size_t(stage)] = state == StageState::done;
  if (running && status_.stage != stage) worked_before_stage_s_ = job_->status().seconds;
  if (running)
    status_.stage = stage;
  else if (status_.stage == stage)
    status_.stage.reset();
}

void PipelineJob::trained(const TrainStatus& status) {
  const std::lock_guard lock(mutex_);
  add_point(status_.curve, status);
  status_.training.push_back(status);
  thin_if_long(status_.training);
}

// Adds what the previews measured on held-out frames to the curve that the training wrote.
void PipelineJob::keep_scores() {
  const std::vector<HeldOutScore> scores = preview_ ? preview_->scores() : std::vector<HeldOutScore>{};
  if (scores.empty()) return;
  const std::filesystem::path path = training_curve_path(project_);
  auto curve = read_training_curve(path);
  if (!curve) return;
  for (const HeldOutScore& score : scores) add_score(*curve, score);
  (void)write_training_curve(path, *curve);  // a failure here must not fail the training
}

PipelineStatus PipelineJob::status() const {
  PipelineStatus status;
  double before_stage = 0;
  {
    const std::lock_guard lock(mutex_);
    status = status_;
    before_stage = worked_before_stage_s_;
  }
  status.job = job_->status();
  const double stage_seconds = status.job.seconds - before_stage;
  if (!is_working(status.job)) status.stage.reset();
  if (status.stage && is_working(status.job)) {
    const auto [from, to] = stage_span(project_.options, last_, *status.stage);
    const double now = std::clamp(status.job.fraction, from, to);
    status.stage_fraction = (now - from) / (to - from);
    // The rate is that of this run: a continued training does not start at step 0.
    status.stage_seconds_left = estimate_left(from, now, to, stage_seconds);
    if (*status.stage == Stage::train && !status.training.empty()) {
      const double budget = project_.options.train.budget_s, spent = status.training.back().seconds;
      if (project_.options.train.steps == 0)
        status.stage_seconds_left = std::max(0.0, budget - spent);
      else if (const auto rate = double(status.training.back().step - status.training.front().step);
               rate > 0 && spent > status.training.front().seconds + 2)
        status.stage_seconds_left = double(project_.options.train.steps - status.training.back().step) *
                                    (spent - status.training.front().seconds) / rate;
    }
    if (status.stage_seconds_left >= 0) {
      // Later stages are estimated by their shares, relative to the training's budget if there is one.
      const auto [train_from, train_to] = stage_span(project_.options, Stage::train, Stage::train);
      const double whole = last_ == Stage::train && project_.options.train.steps == 0
                               ? project_.options.train.budget_s / (train_to - train_from)
                               : stage_seconds / std::max(1e-3, now - from);
      status.job.seconds_left = status.stage_seconds_left + whole * (1 - to);
    } else {
      status.job.seconds_left = -1;
    }
  }
  if (preview_) {
    status.preview = preview_->latest();
    for (const HeldOutScore& score : preview_->scores()) add_score(status.curve, score);
  }
  return status;
}

}  // namespace likeness::ui
