// The studio's comparison with other methods (likeness study PROJECT) beside the open project: what is asked
// for, how long that will take, the work, and what it found.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/image/image.h"
#include "core/lab/study/study_forecast.h"
#include "core/lab/study/study_summary.h"
#include "ui/studio/job.h"
#include "ui/studio/session_context.h"

namespace likeness::ui {

struct StudyChoice {
  std::vector<std::string> tables{"models"};  // of study_tables()
  double seconds = 90;                        // of processor, of each training
  int seeds = 1;

  bool operator==(const StudyChoice&) const = default;
};
inline constexpr double kStudySeconds[] = {30, 90, 300};
inline constexpr int kStudySeeds[] = {1, 3};

// Read in the background.
struct FinishedStudy {
  StudySummary summary;
  std::vector<Image8> plots;  // as in the summary; empty ones could not be read
};

// For the panels.
struct StudyView {
  bool open = false;  // its page is shown in place of the Train step
  StudyChoice choice;
  std::optional<StudyForecast> forecast;  // of the choice; absent: not estimated yet
  JobStatus job;
  std::string missing;  // what is to be done before anything can be compared; empty: nothing
  std::shared_ptr<const FinishedStudy> finished;  // null: there is none
  std::optional<Error> unreadable;                // where there is one that cannot be read
};

// What the panels ask for.
struct StudyRequests {
  std::optional<StudyChoice> choice;
  bool close = false;  // its page
};

class StudySession {
 public:
  explicit StudySession(const SessionContext& context) : context_(context) {}

  void tick();
  StudyView view() const;
  void apply(const StudyRequests& requests);
  void open_page();
  void close_page() { open_ = false; }
  bool is_open() const { return open_; }  // its page
  // project: with its stages' records as they are now.
  void start(Project project);
  void stop();
  void show_results() const;  // their folder, in the desktop's file manager
  void forget();              // the project is closed
  bool is_working() const { return job_ && ui::is_working(job_->status()); }
  bool goes_on() const { return job_ && job_->status().state == JobState::running; }
  bool has_results() const { return finished_ != nullptr; }

 private:
  ModelStudyOptions options() const;
  void forecast();
  void read_results();

  const SessionContext context_;
  bool open_ = false;
  StudyChoice choice_;
  std::optional<StudyForecast> forecast_;  // of the choice
  std::shared_ptr<const FinishedStudy> finished_;
  std::optional<Error> unreadable_;
  JobState seen_ = JobState::none;
  std::unique_ptr<Job> job_;
};

}  // namespace likeness::ui
