// The comparison with other methods (likeness study PROJECT) beside the open project: see studio.h.
#include "ui/studio/studio.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"
#include "core/image/files.h"
#include "core/project/comparison_folder.h"
#include "ui/platform/show_folder.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

constexpr Stage kNeeded[] = {Stage::import, Stage::align, Stage::fit, Stage::matte};

// What keeps a project from being studied, in words with what to do; empty: nothing.
std::string missing_words(const ProjectContents& contents) {
  if (std::ranges::any_of(kNeeded, [&](Stage s) { return contents.is_stale(s); }))
    return "The track or the masks are older than what you chose since. Make the avatar again first.";
  if (!std::ranges::all_of(kNeeded, [&](Stage s) { return contents.is_current(s); }))
    return "There is nothing to compare yet. Make the avatar first: every method learns from the same "
           "pictures, track and masks.";
  return {};
}

}  // namespace

ModelStudyOptions Studio::study_options() const {
  ModelStudyOptions options = options_.study;
  options.tables = study_choice_.tables;
  options.seconds = study_choice_.seconds;
  options.seeds = study_choice_.seeds;
  return options;
}

bool Studio::studies() const { return study_ && ui::is_working(study_->status()); }

void Studio::open_study(bool open) {
  study_open_ = open && open_.contents;
  if (!study_open_) return;
  shown_.step = Step::train;
  shown_.follow = false;
  forecast_the_study();
  read_study();
}

void Studio::forecast_the_study() {
  study_forecast_.reset();
  if (study_choice_.tables.empty()) return;
  background_.run(
      "study forecast",
      [this, folder = open_.folder, options = study_options()](std::stop_token) -> Background::Delivery {
        const StudyForecast forecast =
            forecast_study(comparison_folder({.folder = folder}), options, current_thread_limit());
        return
            [this, folder, forecast, choice = StudyChoice{options.tables, options.seconds, options.seeds}] {
              if (folder == open_.folder && choice == study_choice_) study_forecast_ = forecast;
            };
      });
}

// What was finished, now or on another day.
void Studio::read_study() {
  background_.run("study results", [this, folder = open_.folder](std::stop_token) -> Background::Delivery {
    auto summary = read_study_summary(comparison_folder({.folder = folder}));
    std::shared_ptr<FinishedStudy> finished;
    std::optional<Error> failed;
    if (summary) {
      finished = std::make_shared<FinishedStudy>(FinishedStudy{std::move(*summary), {}});
      for (const SummaryPlot& plot : finished->summary.plots) {
        auto picture = read_image(plot.file);
        finished->plots.push_back(picture ? std::move(*picture) : Image8{});
      }
    } else if (summary.error().code != ErrorCode::not_found) {
      failed = summary.error();
    }
    return [this, folder, finished, failed] {
      if (folder == open_.folder) studied_ = finished, study_unreadable_ = failed;
    };
  });
}

void Studio::start_study() {
  background_.retire(std::move(study_));
  seen_study_ = JobState::running;
  save_strokes();
  study_ = std::make_unique<Job>(
      [project = latest_project(), options = study_options(), written = background_.after_waiting()](
          const Progress& progress, std::stop_token stop) -> Result<std::string> {
        written.wait();
        const auto study = study_models_of(project, comparison_folder(project), options,
                                           progress.stage(0, 1, "comparison"), stop);
        if (!study) return study.error();
        return fmt::format("{} methods were compared on {} frames that none of them had seen.",
                           study->rows.size(), study->frames.size());
      },
      wake_);
}

void Studio::take_study() {
  if (!study_) return;
  const JobState now = study_->status().state;
  if (now == seen_study_) return;
  seen_study_ = now;
  if (ui::is_working(study_->status())) return;
  forecast_the_study();  // of what is left
  if (now == JobState::done) {
    read_study();
    if (!study_open_) notices_.message = study_->status().outcome;
  }
  if (now == JobState::failed && !study_open_ && study_->status().error)
    notices_.fail(*study_->status().error);
}

void Studio::forget_study() {
  background_.retire(std::move(study_));
  study_open_ = false;
  studied_.reset();
  study_forecast_.reset();
  study_unreadable_.reset();
}

void Studio::show_study() {
  if (const auto shown = show_folder(comparison_folder(open_.contents->project)); !shown)
    notices_.fail(shown.error());
}

StudyView Studio::study_view() const {
  StudyView view;
  view.open = study_open_;
  view.choice = study_choice_;
  view.forecast = study_forecast_;
  if (study_) view.job = study_->status();
  if (open_.contents) view.missing = missing_words(*open_.contents);
  view.finished = studied_;
  view.unreadable = study_unreadable_;
  return view;
}

}  // namespace likeness::ui
