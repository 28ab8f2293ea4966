// A project's stages at work: run_stages on a thread, seen through snapshots.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/project/run_stages.h"
#include "ui/job.h"
#include "ui/training_preview.h"

namespace likeness::ui {

struct PipelineStatus {
  JobStatus job;
  std::optional<Stage> stage;  // at work
  double stage_fraction = 0;   // of it
  double stage_seconds_left = -1;
  std::array<StageRecord, kStages.size()> records;
  std::array<bool, kStages.size()> finished{};  // in this run
  std::vector<TrainStatus> training;            // in order, thinned to about a thousand
  std::vector<PreviewScore> held_out;
  std::shared_ptr<const PreviewPictures> preview;
};

class PipelineJob {
 public:
  // Makes what is not there yet. previews: show the avatar while it is trained.
  PipelineJob(Project project, bool previews, std::function<void()> wake);

  PipelineStatus status() const;
  void stop() { job_->stop(); }
  const Project& started_with() const { return project_; }

 private:
  void stage_changed(Stage stage, const StageRecord& record);
  void trained(const TrainStatus& status);

  const Project project_;
  mutable std::mutex mutex_;
  PipelineStatus status_;
  std::chrono::steady_clock::time_point stage_start_;
  std::unique_ptr<TrainingPreview> preview_;
  std::unique_ptr<Job> job_;  // last: ends before what it uses
};

}  // namespace likeness::ui
