// See study_session.h.
#include "ui/studio/study_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"
#include "core/image/files.h"
#include "core/project/comparison_folder.h"
#include "ui/platform/show_folder.h"

namespace likeness::ui {

namespace {

constexpr Stage kNeeded[] = {Stage::import, Stage::align, Stage::fit, Stage::matte};

// Why a project cannot be studied yet and what to do about it; empty: it can.
std::string missing_words(const ProjectContents& contents) {
  if (std::ranges::any_of(kNeeded, [&](Stage s) { return contents.is_stale(s); }))
    return "The track or the masks are older than your latest choices. Make the avatar again first.";
  if (!std::ranges::all_of(kNeeded, [&](Stage s) { return contents.is_current(s); }))
    return "There is nothing to compare yet. Make the avatar first: every method learns from the same "
           "pictures, track and masks.";
  return {};
}

}  // namespace

ModelStudyOptions StudySession::options() const {
  ModelStudyOptions options = context_.options.study;
  options.tables = choice_.tables;
  options.seconds = choice_.seconds;
  options.seeds = choice_.seeds;
  return options;
}

void StudySession::open_page() {
  open_ = context_.open.contents != nullptr;
  if (!open_) return;
  context_.shown = {Step::train, false};
  forecast();
  read_results();
}

void StudySession::apply(const StudyRequests& requests) {
  if (requests.choice && !is_working()) {
    choice_ = *requests.choice;
    forecast();
  }
  if (requests.close) close_page();
}

void StudySession::forecast() {
  forecast_.reset();
  if (choice_.tables.empty()) return;
  context_.background.run("study forecast",
                          [this, folder = context_.open.folder, choice = choice_,
                           options = options()](std::stop_token) -> Background::Delivery {
                            const StudyForecast forecast = forecast_study(
                                comparison_folder({.folder = folder}), options, current_thread_limit());
                            return [this, folder, forecast, choice] {
                              if (folder == context_.open.folder && choice == choice_) forecast_ = forecast;
                            };
                          });
}

// Results of an earlier comparison, too.
void StudySession::read_results() {
  context_.background.run(
      "study results", [this, folder = context_.open.folder](std::stop_token) -> Background::Delivery {
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
          if (folder == context_.open.folder) finished_ = finished, unreadable_ = failed;
        };
      });
}

void StudySession::start(Project project) {
  context_.background.retire(std::move(job_));
  seen_ = JobState::running;
  job_ = std::make_unique<Job>(
      [project = std::move(project), options = options(), written = context_.background.after_waiting()](
          const Progress& progress, std::stop_token stop) -> Result<std::string> {
        written.wait();
        const auto study = study_models_of(project, comparison_folder(project), options,
                                           progress.stage(0, 1, "comparison"), stop);
        if (!study) return study.error();
        return fmt::format("{} methods were compared on {} frames that none of them had seen.",
                           study->rows.size(), study->frames.size());
      },
      context_.wake);
}

void StudySession::stop() {
  if (job_) job_->stop();
}

void StudySession::tick() {
  if (!job_) return;
  const JobStatus status = job_->status();
  if (status.state == seen_) return;
  seen_ = status.state;
  if (ui::is_working(status)) return;
  forecast();  // for what is left
  if (status.state == JobState::done) {
    read_results();
    if (!open_) context_.notices.message = status.outcome;
  }
  if (status.state == JobState::failed && !open_ && status.error) context_.notices.fail(*status.error);
}

void StudySession::forget() {
  context_.background.retire(std::move(job_));
  open_ = false;
  finished_.reset();
  forecast_.reset();
  unreadable_.reset();
}

void StudySession::show_results() const {
  if (const auto shown = show_folder(comparison_folder(context_.open.contents->project)); !shown)
    context_.notices.fail(shown.error());
}

StudyView StudySession::view() const {
  StudyView view;
  view.open = open_;
  view.choice = choice_;
  view.forecast = forecast_;
  if (job_) view.job = job_->status();
  if (context_.open.contents) view.missing = missing_words(*context_.open.contents);
  view.finished = finished_;
  view.unreadable = unreadable_;
  return view;
}

}  // namespace likeness::ui
