// What a stage's run is given, and the runs: a file each, run_STAGE.cpp. For run_stages.cpp alone.
#pragma once

#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/project/project.h"
#include "core/project/run_observer.h"
#include "core/project/stage_inputs.h"

namespace likeness {

struct StageContext {
  Project& project;           // folder, consent and clips; its options are read as `inputs`
  const StageInputs& inputs;  // those that the stage's hash names
  StageRecord& record;
  const StageRecord& before;  // of the run before this one
  const Progress& progress;
  const RunObserver& observer;
  const TrainingPlace& place;
  std::stop_token stop;
};

Result<void> run_import(const StageContext& context);
Result<void> run_align(const StageContext& context);
Result<void> run_fit(const StageContext& context);
Result<void> run_matte(const StageContext& context);
Result<void> run_train(const StageContext& context);

}  // namespace likeness
