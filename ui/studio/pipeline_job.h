// A project's stages at work: run_stages on a thread, seen through snapshots.
#pragma once

#include <array>
#include <functional>
#include <future>
#include <latch>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/project/run_stages.h"
#include "core/project/training_curve.h"
#include "ui/studio/job.h"
#include "ui/studio/training_preview.h"

namespace likeness::ui {

struct PipelineStatus {
  JobStatus job;
  std::optional<Stage> stage;  // at work
  double stage_fraction = 0;   // of it
  double stage_seconds_left = -1;
  std::array<StageRecord, kStages.size()> records;
  std::array<bool, kStages.size()> finished{};  // in this run
  std::optional<Stage> failed;                  // for a further clip
  std::vector<AvatarPart> parts;                // of the avatar that is trained in this run, and why
  std::vector<TrainStatus> training;            // of this run, in order, thinned to about a thousand
  TrainingCurve curve;                          // with what earlier runs left in the project
  std::shared_ptr<const PreviewPictures> preview;
};

// Where trainings and pictures compute.
struct ComputePlace {
  OpenBackend open;        // empty: the processor
  bool fall_back = false;  // a training whose device fails goes on with the processor; pictures always do
};

class PipelineJob {
 public:
  // Makes what is not there yet, up to and including `last`. previews: show the avatar while it is trained.
  // written: ready once the project's files are as they are meant.
  PipelineJob(Project project, Stage last, bool previews, std::function<void()> wake,
              std::shared_future<void> written, ComputePlace place = {});

  PipelineStatus status() const;
  void stop() { job_->stop(); }
  void pause() { job_->pause(); }
  void go_on() { job_->go_on(); }

 private:
  void stage_changed(Stage stage, const StageRecord& record);
  void further_changed(Stage stage, StageState state);
  void trained(const TrainStatus& status);
  void keep_scores();

  const Project project_;
  const Stage last_;
  const ComputePlace place_;
  mutable std::mutex mutex_;
  PipelineStatus status_;
  double worked_before_stage_s_ = 0;
  std::unique_ptr<TrainingPreview> preview_;
  std::latch made_{1};        // the job may ask itself
  std::unique_ptr<Job> job_;  // last: ends before what it uses
};

}  // namespace likeness::ui
