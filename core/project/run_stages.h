// Running a project: each stage whose inputs changed or whose result is absent, in order.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/project/project.h"
#include "core/train/choose_parts.h"
#include "core/train/train.h"

namespace likeness {

// What a watcher of a run may want to see while it lasts. Called from the running thread.
struct RunObserver {
  std::function<void(Stage, const StageRecord&)> stage_changed = [](Stage, const StageRecord&) {};
  // The same of a further clip, by its number.
  std::function<void(Stage, int, const Project&)> further_changed = [](Stage, int, const Project&) {};
  std::function<void(const TrainStatus&)> training = [](const TrainStatus&) {};
  // What the training's avatar is made of, and why: once, before its first step.
  std::function<void(const std::vector<AvatarPart>&)> parts = [](const std::vector<AvatarPart>&) {};
  AvatarTap tap;  // of the training
  // Where the training computes (TrainOptions); what comes out is the same project.
  std::shared_ptr<Backend> backend;
  bool fall_back = false;
  FieldPrecision precision = FieldPrecision::bf16;
};

// The part of a run's progress that a stage takes, from and to in [0, 1].
std::pair<double, double> stage_span(const ProjectOptions& options, Stage last, Stage stage);

// Everything that the stage's result depends on, as one hash. Results of earlier stages count by content, so
// an edited track.json is honoured.
std::string input_hash(const Project& project, Stage stage);

// Whether the stage's result is there and made from what is there now, for further clips, too.
bool is_current(const Project& project, Stage stage);
// The same of this clip by itself.
bool is_current_alone(const Project& project, Stage stage);

// Of all stages at once: every input is read and hashed a few times only.
struct Freshness {
  std::array<bool, kStages.size()> current{};  // as is_current
  // A result is there that was made from other choices or inputs than those there are now, or builds on one
  // that was: a new run replaces it.
  std::array<bool, kStages.size()> stale{};
};
Freshness read_freshness(const Project& project);

// Runs all stages up to and including `last` that are not current. A stop or a failure leaves finished stages
// and the interrupted stage's checkpoint; calling again continues. Takes the project's lock.
Result<void> run_stages(Project& project, Stage last, const Progress& progress, const RunObserver& observer,
                        std::stop_token stop);

// The head model a project uses.
Result<HeadModel> project_head_model(const ProjectOptions& options);

// How a project is trained, by its choices; where it computes is the observer's. The parts that are for the
// capture to decide are the usual ones (apply_parts, core/train/choose_parts.h).
TrainOptions training_options(const ProjectOptions& options);
// Chooses the parts for a set with its pictures, by what it measures and what the project's choices fix, and
// changes set and options to a training with them.
ChosenParts take_parts(const Project& project, TrainingSet& set, TrainOptions& options);

}  // namespace likeness
