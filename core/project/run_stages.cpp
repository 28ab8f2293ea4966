// The order of the stages: see run_stages.h. Each stage's run: stage_run.h.
#include "core/project/run_stages.h"

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/files.h"
#include "core/project/care.h"
#include "core/project/further_clips.h"
#include "core/project/private_folder.h"
#include "core/project/stage_inputs.h"
#include "core/project/stage_results.h"
#include "core/project/stage_run.h"
#include "core/project/staleness.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

Result<void> run_stage(Stage stage, const StageContext& context) {
  // The stages that read the clip itself. If it was never imported, its reader's error says more.
  const bool reads_clip = stage == Stage::import || stage == Stage::align || stage == Stage::fit;
  if (reads_clip && path_exists(capture_path(context.project)))
    if (auto missing = missing_clip(context.project)) return *missing;
  switch (stage) {
    case Stage::import:
      return run_import(context);
    case Stage::align:
      return run_align(context);
    case Stage::fit:
      return run_fit(context);
    case Stage::matte:
      return run_matte(context);
    case Stage::train:
      return run_train(context);
  }
  return {};
}

// Seconds a stage is expected to take relative to the others; used only to divide the progress bar.
double expected_seconds(const TrainInputs& training, Stage stage) {
  switch (stage) {
    case Stage::import:
      return 15;
    case Stage::align:
      return 30;
    case Stage::fit:
      return 120;
    case Stage::matte:
      return 40;
    case Stage::train:
      return training.choices.steps > 0 ? 200 : training.choices.budget_s;
  }
  return 1;
}

// What all stages of a run share.
struct RunTerms {
  const RunObserver& observer;
  const TrainingPlace& place;
  std::stop_token stop;
  std::string& lock_note;  // for the first stage that runs to tell; then empty
};

// One stage of one clip that is not current; its record on disk follows. The record names what the result was
// made from.
Result<void> run_one(Project& project, Stage stage, const Progress& progress, const RunTerms& terms,
                     const std::function<void(const StageRecord&)>& changed) {
  StageRecord& record = project.record(stage);
  const std::string hash = input_hash(project, stage);
  const StageRecord before = record;
  const auto changed_results = keep_changed(project, stage);
  if (!changed_results) return changed_results.error();
  const bool retouched = before.state == StageState::done && !before.pictures_hash.empty() &&
                         before.pictures_hash != pictures_hash(project, stage);
  if (record.input_hash != hash || before.state == StageState::done) record = StageRecord{.input_hash = hash};
  record.state = StageState::running;
  if (const auto saved = save_project(project); !saved) return saved.error();
  changed(record);

  const StageInputs inputs = stage_inputs(project.options);
  const auto start = std::chrono::steady_clock::now();
  const auto outcome =
      run_stage(stage, {project, inputs, record, before, progress, terms.observer, terms.place, terms.stop});
  record.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!terms.lock_note.empty()) record.warnings.push_back(std::exchange(terms.lock_note, ""));
  if (!changed_results->empty())
    record.warnings.push_back(fmt::format(
        "What an earlier run wrote had been altered or damaged since, and was made again; it is kept as {}.",
        fmt::join(*changed_results, ", ")));
  if (retouched && record.input_hash == before.input_hash)
    record.warnings.push_back("Pictures of an earlier run had been altered since, and were made again.");
  keep_private(project.folder);
  if (outcome) {
    record.state = StageState::done;
    record.results = stage_results(project, stage);
    record.pictures_hash = pictures_hash(project, stage);
  } else {
    record.state = outcome.error().code == ErrorCode::cancelled ? StageState::stopped : StageState::failed;
    record.message = outcome.error().what;
  }
  const auto saved = save_project(project);  // before a listener may read it
  if (!outcome) return outcome.error();
  return saved;
}

// Whether a stage need not be run: its result is current, and whole to the last picture, too. A project from
// before that was kept takes what can be read as it is.
bool is_whole(Project& project, Stage stage) {
  if (!is_current_alone(project, stage)) return false;
  StageRecord& record = project.record(stage);
  if (record.results.empty()) {
    if (!results_readable(project, stage)) return false;
    record.results = stage_results(project, stage);
    record.pictures_hash = pictures_hash(project, stage);
    (void)save_project(project);  // else it is found out again
  }
  return record.pictures_hash == pictures_hash(project, stage);
}

// The stage of every further clip that needs it.
Result<void> run_further(const Project& project, Stage stage, const Progress& progress,
                         const RunTerms& terms) {
  const std::size_t count = project.further_clips.size();
  for (std::size_t i = 0; i < count; ++i) {
    const int number = project.further_clips[i];
    auto further = open_further_clip(project, number);
    if (!further) return further.error();
    if (is_whole(*further, stage)) continue;
    const Progress part = progress.stage(double(i) / double(count), double(i + 1) / double(count),
                                         fmt::format("clip {}", number));
    const auto changed = [&](const StageRecord&) { terms.observer.further_changed(stage, number, *further); };
    const auto done = run_one(*further, stage, part, terms, changed);
    terms.observer.further_changed(stage, number, *further);
    if (done) continue;
    Error error = done.error();
    if (error.code != ErrorCode::cancelled) {
      error.what = fmt::format("{}: {}", further_clip_name(*further, number), error.what);
      error.fix +=
          fmt::format(" Or remove the clip: likeness clips {} --remove {}", project.folder.string(), number);
    }
    return error;
  }
  return {};
}

}  // namespace

std::pair<double, double> stage_span(const ProjectOptions& options, Stage last, Stage stage) {
  const TrainInputs training = stage_inputs(options).train;
  double total = 0, before = 0;
  for (const Stage other : kStages) {
    if (other <= last) total += expected_seconds(training, other);
    if (other < stage) before += expected_seconds(training, other);
  }
  return {before / total, (before + expected_seconds(training, stage)) / total};
}

Result<void> run_stages(Project& project, Stage last, const Progress& progress, const RunObserver& observer,
                        std::stop_token stop, const TrainingPlace& place) {
  const auto lock = ProjectLock::acquire(project);
  if (!lock) return lock.error();
  std::string lock_note = lock->note();
  const RunTerms terms{observer, place, stop, lock_note};
  remove_abandoned_parts(project.folder);
  for (const Stage stage : kStages) {
    if (stage > last) break;
    const auto [from, to] = stage_span(project.options, last, stage);
    const std::size_t others = stage == Stage::train ? 0 : project.further_clips.size();
    const double own = from + (to - from) / double(1 + others);
    const std::string name(stage_name(stage));
    if (!is_whole(project, stage)) {
      const auto changed = [&](const StageRecord& record) { observer.stage_changed(stage, record); };
      const auto done = run_one(project, stage, progress.stage(from, own, name), terms, changed);
      observer.stage_changed(stage, project.record(stage));
      if (!done) return done.error();
    }
    if (others > 0)
      if (const auto done = run_further(project, stage, progress.stage(own, to, name), terms); !done)
        return done.error();
    progress.report(to);
  }
  return {};
}

}  // namespace likeness
