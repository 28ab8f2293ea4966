// From stages to the steps of the guided path: see step_views.h.
#include "ui/studio/step_views.h"

#include <fmt/format.h>
#include <algorithm>

namespace likeness::ui {

namespace {

std::vector<Stage> stages_of(Step step) {
  switch (step) {
    case Step::check:
      return {Stage::import};
    case Step::cameras:
      return {Stage::align};
    case Step::face:
      return {Stage::fit, Stage::matte};
    case Step::train:
      return {Stage::train};
    default:
      return {};
  }
}

StepView film_view(const ProjectContents& contents) {
  StepView view;
  if (contents.clip)
    view.found = fmt::format("{}, {} \u00d7 {} px, {:.0f} s.",
                             contents.project.options.shared.video.filename().string(), contents.clip->width,
                             contents.clip->height, contents.clip->duration_s);
  if (contents.project.consent == Consent::not_asked) {
    view.state = StepState::needs_you;
    view.next = "Say whether the filmed person agreed.";
    return view;
  }
  const bool needed = !contents.is_current(Stage::import) || !contents.is_current(Stage::align) ||
                      !contents.is_current(Stage::fit);
  if (!contents.clip && needed) {
    view.state = contents.capture ? StepState::needs_you : StepState::failed;
    view.found = "The clip is not where it was.";
    view.next = "Say where it is now: Find the clip.";
    view.error = Error{ErrorCode::not_found,
                       fmt::format("The clip {} is not where it was, or cannot be read.",
                                   contents.project.options.shared.video.string()),
                       "Put it back, or press Find the clip and say where it is now.", ""};
    return view;
  }
  view.state = StepState::done;
  if (!contents.clip) view.found = "The clip has moved; what was read from it is kept.";
  return view;
}

// Frames of an import that will not train although nothing holds them out.
// Of a film that was cut, the shots that are left out were not refused for what they show.
int refused_frames(const Capture& capture) {
  const std::vector<FrameSpan> shots = spans_where_cut(capture);
  return int(std::ranges::count_if(capture.frames, [&](const CaptureFrame& f) {
    return !f.used && !f.held_out && span_of(shots, f.frame) >= 0;
  }));
}

void add_next(Step step, const ProjectContents& contents, StepView& view) {
  if (view.state != StepState::done) return;
  if (step == Step::check && contents.capture) {
    const int refused = refused_frames(*contents.capture);
    if (refused > int(contents.capture->frames.size()) / 4)
      view.next = "Many frames were refused: look at the reasons and film again in better light.";
  }
  if (step == Step::face && contents.track) {
    std::vector<FrameSpan> shots;
    if (contents.capture) shots = spans_where_cut(*contents.capture);
    const auto lost = std::ranges::count_if(contents.track->frames, [&](const TrackedFrame& f) {
      return f.status == FrameStatus::lost && span_of(shots, f.frame) >= 0;
    });
    if (lost > 0)
      view.next =
          fmt::format("The head was lost in {} frame{}: look at the red bars.", lost, lost == 1 ? "" : "s");
  }
}

StepView work_view(Step step, const ProjectContents& contents, const PipelineStatus& pipeline) {
  const bool working = is_working(pipeline.job);
  StepView view;
  bool done = true;
  for (const Stage stage : stages_of(step)) {
    const bool live = working || pipeline.job.state != JobState::none;
    const StageRecord& record = live ? pipeline.records[std::size_t(stage)] : contents.project.record(stage);
    const bool finished = pipeline.finished[std::size_t(stage)] || contents.is_current(stage);
    const bool stale = !working && contents.is_stale(stage);
    done &= finished && !stale;
    if (!record.message.empty() && (finished || record.state == StageState::failed))
      view.found += (view.found.empty() ? "" : " ") + record.message;
    view.warnings.insert(view.warnings.end(), record.warnings.begin(), record.warnings.end());
    if (working && pipeline.stage == stage) {
      view.state = StepState::running;
      view.text = pipeline.job.state == JobState::stopping ? "Stopping; what was done is kept"
                  : pipeline.job.waiting                   ? "Paused"
                  : pipeline.job.paused                    ? "Pausing\u2026"
                                                           : pipeline.job.text;
      view.paused = pipeline.job.paused;
      view.fraction = pipeline.stage_fraction;
      view.seconds_left = pipeline.job.paused ? -1 : pipeline.stage_seconds_left;
      return view;
    }
    if (!finished && (record.state == StageState::failed || pipeline.failed == stage)) {
      view.state = StepState::failed;
      if (pipeline.job.error && pipeline.job.state == JobState::failed) {
        view.error = pipeline.job.error;
        view.next = pipeline.job.error->fix;
      } else {
        view.error =
            Error{ErrorCode::failed, record.message, "Make the avatar again: this step is repeated.", ""};
        view.next = view.error->fix;
      }
      return view;
    }
    const bool interrupted = record.state == StageState::running;  // the program was killed
    if (!finished && !working && (record.state == StageState::stopped || interrupted)) {
      view.state = StepState::needs_you;
      view.found =
          interrupted ? "Interrupted. What was done by then is kept." : "Stopped. What was done is kept.";
      view.next = "Continue when you like.";
      return view;
    }
    if (stale) {
      view.state = StepState::stale;
      view.found = stage == Stage::matte && !contents.strokes.empty()
                       ? "Made before the last change of choices or brush strokes."
                       : "Made before the last change of choices.";
      view.next = "Make the avatar again: only what changed is redone.";
      view.warnings.clear();
      return view;
    }
  }
  view.state = done ? StepState::done : StepState::to_do;
  if (!done) view.found.clear();
  add_next(step, contents, view);
  return view;
}

}  // namespace

std::string_view step_words(Step step) {
  constexpr std::array<std::string_view, kSteps.size()> kWords{"Film",  "Check",  "Cameras", "Face",
                                                               "Train", "Direct", "Export"};
  return kWords[std::size_t(step)];
}

bool was_interrupted(const ProjectContents& contents, Stage stage) {
  const StageState state = contents.project.record(stage).state;
  return !contents.is_current(stage) && (state == StageState::stopped || state == StageState::running);
}

Step opening_step(const ProjectContents& contents) {
  for (const Step step : {Step::check, Step::cameras, Step::face, Step::train})
    for (const Stage stage : stages_of(step))
      if (was_interrupted(contents, stage) ||
          (!contents.is_current(stage) && contents.project.record(stage).state == StageState::failed))
        return step;
  return contents.avatar ? Step::direct : Step::film;
}

void add_verdict(const JobStatus& checking, const CaptureVerdict* verdict,
                 std::array<StepView, kSteps.size()>& steps) {
  StepView &film = steps[std::size_t(Step::film)], &check = steps[std::size_t(Step::check)];
  const bool imported = check.state == StepState::done,
             made = steps[std::size_t(Step::train)].state == StepState::done;
  if (is_working(checking) && check.state == StepState::to_do) {
    check.state = StepState::running;
    check.text = "Looking at the clip";
    check.fraction = checking.fraction;
    check.seconds_left = checking.seconds_left;
  }
  if (is_working(checking) || !verdict) return;
  const bool again = verdict->verdict == Verdict::refilm;
  const std::string next = verdict->faceless ? "Open another clip."
                           : again           ? "Open another clip, or go on and see how it turns out."
                                             : "Look at the remarks, then make the avatar.";
  if (check.state == StepState::to_do) {
    check.found = verdict_words(*verdict);
    if (verdict->verdict != Verdict::ready) check.state = StepState::needs_you, check.next = next;
  } else if (imported && again) {
    check.found = std::string(verdict_words(*verdict)) + " " + check.found;
    check.state = StepState::needs_you, check.next = next;
  }
  if (again && !made && film.state == StepState::done) film.state = StepState::needs_you, film.next = next;
}

std::array<StepView, kSteps.size()> view_steps(const ProjectContents* contents, bool loading,
                                               const PipelineStatus& pipeline, const JobStatus& exporting,
                                               const std::filesystem::path& exported) {
  std::array<StepView, kSteps.size()> steps;
  if (!contents) {
    if (loading)
      for (StepView& view : steps) view.state = StepState::loading;
    return steps;
  }
  const auto at = [&](Step s) -> StepView& { return steps[std::size_t(s)]; };
  at(Step::film) = film_view(*contents);
  for (const Step step : {Step::check, Step::cameras, Step::face, Step::train})
    at(step) = work_view(step, *contents, pipeline);

  StepView& direct = at(Step::direct);
  if (contents->avatar) {
    direct.state = StepState::done;
    direct.found = "The avatar can be turned and posed.";
    if (at(Step::train).state != StepState::done)
      direct.found = "The avatar of an earlier training can be posed.";
  }
  StepView& out = at(Step::export_out);
  if (is_working(exporting)) {
    out.state = StepState::running;
    out.text = exporting.text;
    out.fraction = exporting.fraction;
    out.seconds_left = exporting.seconds_left;
  } else if (exporting.state == JobState::failed) {
    out.state = StepState::failed;
    out.error = exporting.error;
    out.next = exporting.error ? exporting.error->fix : "";
  } else if (!exported.empty()) {
    out.state = StepState::done;
    out.found = exported.filename().string() + " is written.";
  }
  return steps;
}

}  // namespace likeness::ui
