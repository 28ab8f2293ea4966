// The studio's beginning, end and every tick of it: see studio.h. What is asked of it is carried out in
// studio_requests.cpp and studio_direct.cpp, projects are opened in studio_project.cpp, work is started in
// studio_work.cpp, a webcam is recorded in studio_record.cpp, masks are painted on in studio_masks.cpp,
// pictures of frames come from studio_pictures.cpp, other methods are compared in studio_study.cpp.
#include "ui/studio/studio.h"

#include <algorithm>
#include <utility>

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

constexpr double kOverrunOfTraining = 1.16;  // a budget spent by more than this ends a training at once

}  // namespace

Studio::Studio(StudioOptions options, std::function<void()> wake)
    : options_(std::move(options)),
      wake_(std::move(wake)),
      settings_(read_settings(options_.settings)),
      renderer_(wake_, options_.compute.open),
      exports_(wake_),
      background_(
          [this](const std::string& what) {
            loading_ = false;
            notices_.fail({ErrorCode::failed, "Reading broke off: " + what + ".",
                           "Close other programs and try again.", ""});
          },
          wake_) {}

Studio::~Studio() {
  save_strokes();
  lay_takes();
  save_performance(true);
  save_settings();
}

void Studio::tick() {
  if (auto note = renderer_.take_note()) notices_.message = std::move(*note);
  background_.deliver();
  if (directing_.advance(Directing::Clock::now())) request_picture();
  save_performance(false);
  settle_strokes();
  if (drive_.has_ended()) {
    take_drive();
    if (const auto error = drive_.view().status.error) notices_.fail(*error);
    background_.retire(drive_.stop());
    request_picture();
  }
  if (demo_ && !ui::is_working(demo_->status())) {
    const JobStatus status = demo_->status();
    demo_.reset();
    if (status.error && status.error->code != ErrorCode::cancelled) notices_.fail(*status.error);
    if (!status.error) {
      ProjectOptions project = options_.project;
      open_clip(status.outcome, Consent::no_real_person, project);
    }
  }
  exports_.tick();
  take_study();
  take_recording();
  if (check_ && checked_ && check_->status().state == JobState::done)
    verdict_ = std::exchange(checked_, nullptr);
  if (!pipeline_job_) return;
  open_.pipeline = pipeline_job_->status();
  watch_solve();
  for (const Stage stage : kStages) {
    const StageState now = open_.pipeline.records[std::size_t(stage)].state;
    StageState& before = seen_states_[std::size_t(stage)];
    if (now == before) continue;
    before = now;
    if (now == StageState::done) load(open_.folder);  // another result can be shown
  }
  if (open_.pipeline.stage && shown_.follow && shown_.step != Step::direct &&
      shown_.step != Step::export_out) {
    constexpr std::array<Step, kStages.size()> kShown{Step::check, Step::cameras, Step::face, Step::face,
                                                      Step::train};
    shown_.step = kShown[std::size_t(*open_.pipeline.stage)];
  }
  if (open_.pipeline.job.state != seen_pipeline_ && !open_.is_running()) {
    load(open_.folder);
    if (open_.pipeline.job.state == JobState::done && shown_.follow && shown_.step == Step::train)
      shown_.step = Step::direct;
    if (open_.pipeline.job.state == JobState::stopped && finish_at_s_ && open_.contents) {
      const double budget_s = std::max(1.0, *finish_at_s_ / kOverrunOfTraining);
      finish_at_s_.reset();
      start_pipeline([&](ProjectOptions& o) {
        if (o.steps == 0 && o.full_budget_s == 0) o.full_budget_s = o.budget_s;
        o.steps = 0, o.budget_s = budget_s;
      });
      return;
    }
    finish_at_s_.reset();
    tell_refit();
    const auto told = [](const StageRecord& record) { return record.state == StageState::failed; };
    if (open_.pipeline.job.state == JobState::failed && open_.pipeline.job.error && !open_.pipeline.failed &&
        std::ranges::none_of(open_.pipeline.records, told))
      notices_.fail(*open_.pipeline.job.error);  // of no single stage: a busy project, a full disk, no memory
  }
  seen_pipeline_ = open_.pipeline.job.state;
}

void Studio::remember_window(int width, int height, bool maximised) {
  settings_.maximised = maximised;
  if (!maximised) settings_.width = width, settings_.height = height;
}

void Studio::save_settings() {
  if (const auto saved = write_settings(options_.settings, settings_); !saved)
    notices_.message = saved.error().what;
}

bool Studio::is_working() const {
  return open_.is_running() || (demo_ && ui::is_working(demo_->status())) || exports_.is_working() ||
         studies() || records();
}

bool Studio::computes() const {
  return (open_.is_running() && !open_.pipeline.job.waiting) || (demo_ && ui::is_working(demo_->status())) ||
         exports_.is_working() || studies();
}

bool Studio::goes_on() const {
  const auto runs = [](const JobStatus& status) { return status.state == JobState::running; };
  return (pipeline_job_ && runs(pipeline_job_->status().job)) || (demo_ && runs(demo_->status())) ||
         (study_ && runs(study_->status())) ||
         (recorder_ && recorder_->status().state == RecorderState::recording) ||
         std::ranges::any_of(exports_.items(), [&](const ExportItem& item) {
           return item.status.state == JobState::none || runs(item.status);
         });
}

void Studio::stop_work() {
  finish_at_s_.reset();
  if (demo_) demo_->stop();
  if (pipeline_job_) pipeline_job_->stop();
  exports_.stop_all();
  if (check_) check_->stop();
  if (study_) study_->stop();
  if (records()) {
    open_recorded_ = false;
    recorder_->finish();
  }
}

}  // namespace likeness::ui
