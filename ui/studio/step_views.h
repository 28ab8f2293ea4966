// The steps of the guided path: which there are, and what each says of a project.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/check/verdict.h"
#include "ui/studio/job.h"
#include "ui/studio/pipeline_job.h"
#include "ui/studio/project_contents.h"

namespace likeness::ui {

// The guided path.
enum class Step { film, check, cameras, face, train, direct, export_out };
inline constexpr std::array kSteps{Step::film,  Step::check,  Step::cameras,   Step::face,
                                   Step::train, Step::direct, Step::export_out};
std::string_view step_words(Step step);

enum class StepState {
  to_do,
  loading,
  running,
  needs_you,
  stale,  // done, with other choices than those there are now
  failed,
  done
};

struct StepView {
  StepState state = StepState::to_do;
  std::string found;  // what the step found, one sentence
  std::string next;   // the one next thing to do; empty: nothing here
  std::string text;   // of work in progress
  bool paused = false;
  double fraction = 0;
  double seconds_left = -1;  // negative: not known
  std::vector<std::string> warnings;
  std::optional<Error> error;
};

// The state of each step, from what there is and what is at work.
std::array<StepView, kSteps.size()> view_steps(const ProjectContents* contents, bool loading,
                                               const PipelineStatus& pipeline, const JobStatus& exporting,
                                               const std::filesystem::path& exported);

// Whether the stage was at work and did not come to its end: stopped, or ended with the program.
bool was_interrupted(const ProjectContents& contents, Stage stage);

// Where a project opens: at the work that was interrupted or failed, else at its avatar, else at its clip.
Step opening_step(const ProjectContents& contents);

// What the capture check says of the clip: in its own step, and in the first one while another clip could
// still be taken instead. verdict: null where nobody looked.
void add_verdict(const JobStatus& checking, const CaptureVerdict* verdict,
                 std::array<StepView, kSteps.size()>& steps);

}  // namespace likeness::ui
