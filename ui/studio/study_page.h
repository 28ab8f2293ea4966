// The comparison with other methods as the panels see it: what is asked for, how long that will take, the
// work, and what it found.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/image/image.h"
#include "core/lab/study/study_forecast.h"
#include "core/lab/study/study_summary.h"
#include "ui/studio/job.h"

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

struct StudyView {
  bool open = false;  // its page is shown in place of the Train step
  StudyChoice choice;
  std::optional<StudyForecast> forecast;  // of the choice; absent: not reckoned yet
  JobStatus job;
  std::string missing;  // what is to be done before anything can be compared; empty: nothing
  std::shared_ptr<const FinishedStudy> finished;  // null: none
  std::optional<Error> unreadable;                // where there is one that cannot be read
};

}  // namespace likeness::ui
