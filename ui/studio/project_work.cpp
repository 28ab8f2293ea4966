// The project session's work - stages, demo, check - each in its own threads: see project_session.h.
#include "ui/studio/project_session.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/project/refits.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

constexpr double kOverrunOfTraining = 1.16;  // a budget spent by more than this ends a training at once

void run_out(ProjectOptions& options, double budget_s) {
  if (options.train.steps == 0 && options.train.full_budget_s == 0)
    options.train.full_budget_s = options.train.budget_s;
  options.train.steps = 0, options.train.budget_s = budget_s;
}

}  // namespace

void ProjectSession::tick() {
  take_demo();
  if (check_ && checking_ && check_->status().state == JobState::done) {
    const auto done = std::exchange(checking_, nullptr);
    checked_ = {done, &done->found};
    if (!done->kept) context_.notices.message = done->kept.error().what;
  }
  if (!run_) return;
  open_.pipeline = run_->status();
  watch_solve();
  follow_stages();
  const JobStatus& job = open_.pipeline.job;
  if (job.state != seen_run_ && !open_.is_running()) {
    read_again();
    if (job.state == JobState::done && context_.shown.follow && context_.shown.step == Step::train)
      context_.shown.step = Step::direct;
    if (job.state == JobState::stopped && finish_at_s_ && open_.contents) {
      const double budget_s = std::max(1.0, *std::exchange(finish_at_s_, std::nullopt) / kOverrunOfTraining);
      start_run([&](ProjectOptions& o) { run_out(o, budget_s); });
      return;
    }
    finish_at_s_.reset();
    report_refit();
    const auto failed = [](const StageRecord& record) { return record.state == StageState::failed; };
    if (job.state == JobState::failed && job.error && !open_.pipeline.failed &&
        std::ranges::none_of(open_.pipeline.records, failed))
      context_.notices.fail(*job.error);  // not of one stage: a busy project, a full disk, no memory
  }
  seen_run_ = job.state;
}

// Reads what a stage has just made, and shows the step whose stage runs.
void ProjectSession::follow_stages() {
  for (const Stage stage : kStages) {
    const StageState now = open_.pipeline.records[std::size_t(stage)].state;
    if (now == std::exchange(seen_states_[std::size_t(stage)], now)) continue;
    if (now == StageState::done) read_again();
  }
  ShownStep& shown = context_.shown;
  if (!open_.pipeline.stage || !shown.follow || shown.step == Step::direct || shown.step == Step::export_out)
    return;
  constexpr std::array<Step, kStages.size()> kShown{Step::check, Step::cameras, Step::face, Step::face,
                                                    Step::train};
  shown.step = kShown[std::size_t(*open_.pipeline.stage)];
}

void ProjectSession::take_demo() {
  if (!demo_ || ui::is_working(demo_->status())) return;
  const JobStatus status = demo_->status();
  demo_.reset();
  if (status.error && status.error->code != ErrorCode::cancelled) context_.notices.fail(*status.error);
  if (!status.error) open_clip(status.outcome, Consent::no_real_person);
}

bool ProjectSession::is_filming_demo() const { return demo_ && ui::is_working(demo_->status()); }

bool ProjectSession::is_working() const { return open_.is_running() || is_filming_demo(); }

bool ProjectSession::computes() const {
  return (open_.is_running() && !open_.pipeline.job.waiting) || is_filming_demo();
}

bool ProjectSession::goes_on() const {
  return (run_ && run_->status().job.state == JobState::running) ||
         (demo_ && demo_->status().state == JobState::running);
}

void ProjectSession::pause() {
  if (demo_) demo_->pause();
  if (run_) run_->pause();
}

void ProjectSession::go_on() {
  if (demo_) demo_->go_on();
  if (run_) run_->go_on();
}

void ProjectSession::stop() {
  finish_at_s_.reset();
  if (demo_) demo_->stop();
  if (run_) run_->stop();
}

void ProjectSession::stop_all() {
  stop();
  if (check_) check_->stop();
}

void ProjectSession::make_avatar() {
  context_.shown.follow = true;
  start_run(restore_budget);  // with the whole budget, should a training start again
}

void ProjectSession::train_longer() {
  context_.shown = {Step::train, true};
  start_run([&](ProjectOptions& o) {
    const auto& avatar = open_.contents->avatar;
    const double spent = avatar ? avatar->avatar.train_seconds : o.train.budget_s;
    choose_budget(o, std::max(1.0, std::round(spent)) + context_.options.longer_s);
  });
}

void ProjectSession::finish_training() {
  finish_at_s_ = open_.pipeline.training.back().seconds;
  run_->stop();
}

void ProjectSession::start_run(const std::function<void(ProjectOptions&)>& change, Stage last) {
  if (!open_.contents) return;
  neighbours_.run_begins();
  if (!edit_options(change)) return;
  neighbours_.run_began();
  const Project& project = open_.contents->project;
  refit_.reset();
  seen_run_ = JobState::none;
  for (const Stage stage : kStages) seen_states_[std::size_t(stage)] = project.record(stage).state;
  context_.background.retire(std::move(run_));
  run_ = std::make_unique<PipelineJob>(project, last, context_.options.previews, context_.wake,
                                       context_.background.after_waiting(), context_.options.compute);
  open_.pipeline = run_->status();
}

void ProjectSession::refit(const RefitSpan& span, bool again) {
  if (!open_.contents || open_.is_running()) return;
  if (neighbours_.is_comparing()) {
    context_.notices.fail({ErrorCode::failed, "Nothing is fitted again while other methods are compared.",
                           "Stop the comparison first, or wait until it ends.", ""});
    return;
  }
  const auto with_span = [&](ProjectOptions& options) {
    if (again) {
      options.fit.refits.push_back(span);
      options.fit.refits = merged_spans(std::move(options.fit.refits));
    } else {
      std::erase_if(options.fit.refits, [&](const RefitSpan& other) {
        return other.first <= span.last && span.first <= other.last;
      });
    }
  };
  ProjectOptions known = open_.contents->project.options;
  with_span(known);
  if (const auto fine = again ? check_project_refits(latest(), known.fit.refits) : Result<void>(); !fine) {
    context_.notices.fail(fine.error());
    return;
  }
  context_.shown.follow = false;  // the Face step stays in sight
  start_run(with_span, Stage::fit);
  refit_ = span;
}

// Reports what became of the span that was fitted again.
void ProjectSession::report_refit() {
  if (!refit_ || !open_.contents) return;
  const RefitSpan span = *refit_;
  refit_.reset();
  if (open_.pipeline.job.state != JobState::done) return;
  const auto refits = read_refits(open_.contents->project);
  const RefitOutcome* own = refits ? find_refit(refits->outcomes, span.first) : nullptr;
  if (!own) {
    context_.notices.message = "These frames are as they were first fitted.";
  } else {
    context_.notices.message = refit_words(*own);
    if (own->better > 0) context_.notices.message.append(" Make the avatar again to use it.");
  }
}

// Reads at intervals how far solving the cameras has come.
void ProjectSession::watch_solve() {
  constexpr auto kPause = std::chrono::seconds(1);
  if (open_.pipeline.stage != Stage::align) return solving_.reset();
  const auto now = std::chrono::steady_clock::now();
  if (now - solve_watched_ < kPause) return;
  solve_watched_ = now;
  context_.background.run("solve", [this, folder = open_.folder](std::stop_token) -> Background::Delivery {
    auto solving = read_solving_cameras(folder / "colmap");
    return [this, folder, solving = std::move(solving)]() mutable {
      if (solving && folder == open_.folder && open_.pipeline.stage == Stage::align)
        solving_ = std::move(solving);
    };
  });
}

void ProjectSession::film_demo() {
  close();
  const fs::path clip = context_.projects / "demo" / "demo.mp4";
  demo_ = std::make_unique<Job>(
      [clip, demo = context_.options.demo](const Progress& progress,
                                           std::stop_token stop) -> Result<std::string> {
        std::error_code ignored;
        if (fs::exists(clip, ignored)) return clip.string();
        if (const auto made =
                write_demo_capture(clip.parent_path(), demo, progress.stage(0, 1, "demo"), stop);
            !made)
          return made.error();
        return clip.string();
      },
      context_.wake);
}

void ProjectSession::drop_check() {
  checking_.reset();
  checked_.reset();
  context_.background.retire(std::move(check_));
}

void ProjectSession::check_clip() {
  drop_check();
  checking_ = std::make_shared<ClipCheck>();
  check_ = std::make_unique<Job>(
      [options = open_.contents->project.options, folder = open_.folder, into = checking_](
          const Progress& progress, std::stop_token stop) -> Result<std::string> {
        const auto measures =
            measure_clip(options.shared.video, options.shared.landmark_model, options.shared.person_network,
                         progress.stage(0, 1, "check"), stop);
        if (!measures) return measures.error();
        const auto hash = hash_video(options.shared.video);
        if (!hash) return hash.error();
        into->found = {*hash, judge_capture(*measures), clip_facts(*measures)};
        into->kept = write_checked_clip(checked_clip_path(folder), into->found);
        return std::string(verdict_words(into->found.verdict));
      },
      context_.wake);
}

}  // namespace likeness::ui
