// Claims about the guided path: what each step says in each situation.
#include "ui/studio/step_views.h"

#include <gtest/gtest.h>

namespace likeness::ui {
namespace {

ProjectContents fresh() {
  ProjectContents contents;
  contents.project.options.shared.video = "/clips/me.mp4";
  contents.clip = VideoInfo{.width = 640, .height = 480, .duration_s = 12};
  return contents;
}

const StepView& at(const std::array<StepView, kSteps.size()>& steps, Step step) {
  return steps[std::size_t(step)];
}

TEST(ViewSteps, AFreshProjectAsksForConsentFirst) {
  ProjectContents contents = fresh();
  auto steps = view_steps(&contents, false, {}, {}, {});
  EXPECT_EQ(at(steps, Step::film).state, StepState::needs_you);
  EXPECT_FALSE(at(steps, Step::film).next.empty());
  for (const Step step :
       {Step::check, Step::cameras, Step::face, Step::train, Step::direct, Step::export_out})
    EXPECT_EQ(at(steps, step).state, StepState::to_do);
  contents.project.consent = Consent::own;
  steps = view_steps(&contents, false, {}, {}, {});
  EXPECT_EQ(at(steps, Step::film).state, StepState::done);
}

TEST(ViewSteps, AChoiceThatMakesAResultOldIsShownAtOnce) {
  ProjectContents contents = fresh();
  contents.project.consent = Consent::own;
  contents.current.fill(true);
  for (StageRecord& record : contents.project.stages) record = {StageState::done, "0", 1, "Made.", {"Dark."}};
  EXPECT_EQ(at(view_steps(&contents, false, {}, {}, {}), Step::train).state, StepState::done);
  // Other picture sizes: the cameras stay, what is made of the pictures does not.
  for (const Stage stage : {Stage::import, Stage::fit, Stage::matte, Stage::train})
    contents.stale[std::size_t(stage)] = true;
  contents.current[std::size_t(Stage::import)] = false;
  auto steps = view_steps(&contents, false, {}, {}, {});
  for (const Step step : {Step::check, Step::face, Step::train}) {
    EXPECT_EQ(at(steps, step).state, StepState::stale);
    EXPECT_FALSE(at(steps, step).next.empty());
  }
  EXPECT_EQ(at(steps, Step::cameras).state, StepState::done);
  // At work again, it is no longer old but to be done.
  PipelineStatus pipeline;
  pipeline.job.state = JobState::running;
  pipeline.stage = Stage::import;
  steps = view_steps(&contents, false, pipeline, {}, {});
  EXPECT_EQ(at(steps, Step::check).state, StepState::running);
}

TEST(ViewSteps, APausedStageDiffersFromOneThatWasKilled) {
  ProjectContents contents = fresh();
  PipelineStatus pipeline;
  pipeline.job.state = JobState::running;
  pipeline.job.paused = pipeline.job.waiting = true;
  pipeline.stage = Stage::train;
  auto steps = view_steps(&contents, false, pipeline, {}, {});
  EXPECT_TRUE(at(steps, Step::train).paused);
  EXPECT_EQ(at(steps, Step::train).text, "Paused");
  EXPECT_LT(at(steps, Step::train).seconds_left, 0);
  contents.project.record(Stage::train).state = StageState::running;  // but no program works on it
  steps = view_steps(&contents, false, {}, {}, {});
  EXPECT_EQ(at(steps, Step::train).state, StepState::needs_you);
  EXPECT_NE(at(steps, Step::train).found.find("Interrupted"), std::string::npos);
}

TEST(ViewSteps, AMovedClipIsAskedForOnlyWhileItIsNeeded) {
  ProjectContents contents = fresh();
  contents.project.consent = Consent::own;
  contents.clip.reset();
  contents.capture = std::make_shared<const Capture>();
  contents.current[std::size_t(Stage::import)] = true;
  auto steps = view_steps(&contents, false, {}, {}, {});
  EXPECT_EQ(at(steps, Step::film).state, StepState::needs_you);
  EXPECT_NE(at(steps, Step::film).next.find("Find the clip"), std::string::npos);
  contents.current.fill(true);
  steps = view_steps(&contents, false, {}, {}, {});
  EXPECT_EQ(at(steps, Step::film).state, StepState::done);
  EXPECT_NE(at(steps, Step::film).found.find("moved"), std::string::npos);
}

TEST(ViewSteps, AMissingClipIsAFailureWithARemedy) {
  ProjectContents contents = fresh();
  contents.project.consent = Consent::own;
  contents.clip.reset();
  const auto steps = view_steps(&contents, false, {}, {}, {});
  EXPECT_EQ(at(steps, Step::film).state, StepState::failed);
  ASSERT_TRUE(at(steps, Step::film).error.has_value());
  EXPECT_FALSE(at(steps, Step::film).error->fix.empty());
}

TEST(ViewSteps, TheStepAtWorkShowsItsOwnProgress) {
  const ProjectContents contents = fresh();
  PipelineStatus pipeline;
  pipeline.job.state = JobState::running;
  pipeline.stage = Stage::matte;
  pipeline.stage_fraction = 0.4;
  pipeline.stage_seconds_left = 20;
  pipeline.finished[0] = pipeline.finished[1] = pipeline.finished[2] = true;
  pipeline.records[2].message = "Found.";
  const auto steps = view_steps(&contents, false, pipeline, {}, {});
  EXPECT_EQ(at(steps, Step::check).state, StepState::done);
  EXPECT_EQ(at(steps, Step::face).state, StepState::running);  // fit and matte are one step
  EXPECT_EQ(at(steps, Step::face).fraction, 0.4);
  EXPECT_EQ(at(steps, Step::face).found, "Found.");
  EXPECT_EQ(at(steps, Step::train).state, StepState::to_do);
}

TEST(OpeningStep, IsWhereTheWorkGoesOn) {
  ProjectContents contents = fresh();
  EXPECT_EQ(opening_step(contents), Step::film);
  contents.current.fill(true);
  contents.current[std::size_t(Stage::train)] = false;
  for (const StageState state : {StageState::stopped, StageState::running, StageState::failed}) {
    contents.project.record(Stage::train).state = state;
    EXPECT_EQ(opening_step(contents), Step::train);
    EXPECT_EQ(was_interrupted(contents, Stage::train), state != StageState::failed);
  }
  contents.current[std::size_t(Stage::matte)] = false;
  contents.project.record(Stage::matte).state = StageState::stopped;
  EXPECT_EQ(opening_step(contents), Step::face);
  contents.current.fill(true);
  EXPECT_EQ(opening_step(contents), Step::film);
}

TEST(AddVerdict, StandsInItsOwnStepAndInTheFirstWhileAnotherClipCouldBeTaken) {
  ProjectContents contents = fresh();
  contents.project.consent = Consent::own;
  const auto judged = [&](const CaptureVerdict* verdict, const JobStatus& checking = {}) {
    auto steps = view_steps(&contents, false, {}, {}, {});
    add_verdict(checking, verdict, steps);
    return steps;
  };
  const CaptureVerdict refilm{Verdict::refilm}, usable{Verdict::usable}, ready{Verdict::ready},
      faceless{.verdict = Verdict::refilm, .faceless = true};
  EXPECT_EQ(at(judged(nullptr, {.state = JobState::running, .fraction = 0.5}), Step::check).state,
            StepState::running);
  for (const CaptureVerdict* verdict : {&refilm, &faceless})
    for (const Step step : {Step::film, Step::check}) {
      EXPECT_EQ(at(judged(verdict), step).state, StepState::needs_you);
      EXPECT_NE(at(judged(verdict), step).next.find("Open another clip"), std::string::npos);
    }
  EXPECT_EQ(at(judged(&usable), Step::check).state, StepState::needs_you);
  EXPECT_EQ(at(judged(&usable), Step::film).state, StepState::done);
  EXPECT_EQ(at(judged(&ready), Step::check).state, StepState::to_do);
  EXPECT_FALSE(at(judged(&ready), Step::check).found.empty());
  // Imported all the same: no tick over a red page.
  contents.current[std::size_t(Stage::import)] = true;
  contents.project.record(Stage::import) = {StageState::done, "0", 1, "300 frames.", {}};
  EXPECT_EQ(at(judged(&refilm), Step::check).state, StepState::needs_you);
  EXPECT_NE(at(judged(&refilm), Step::check).found.find("300 frames."), std::string::npos);
  EXPECT_EQ(at(judged(&usable), Step::check).state, StepState::done);
  contents.current.fill(true);  // nothing is left to decide
  EXPECT_EQ(at(judged(&refilm), Step::film).state, StepState::done);
}

TEST(ViewSteps, AFailedStageDiffersFromAPausedOne) {
  ProjectContents contents = fresh();
  contents.project.record(Stage::import) = {StageState::failed, "", 1, "No face in 90 frames.", {}};
  auto steps = view_steps(&contents, false, {}, {}, {});
  EXPECT_EQ(at(steps, Step::check).state, StepState::failed);
  EXPECT_EQ(at(steps, Step::check).error->what, "No face in 90 frames.");
  contents.project.record(Stage::import).state = StageState::stopped;
  steps = view_steps(&contents, false, {}, {}, {});
  EXPECT_EQ(at(steps, Step::check).state, StepState::needs_you);
  // The remedy of a run that has just failed is the stage's own.
  PipelineStatus pipeline;
  pipeline.job.state = JobState::failed;
  pipeline.job.error = Error{ErrorCode::no_face, "No face.", "Film again.", ""};
  pipeline.records[0].state = StageState::failed;
  steps = view_steps(&contents, false, pipeline, {}, {});
  EXPECT_EQ(at(steps, Step::check).next, "Film again.");
}

TEST(ViewSteps, AFurtherClipThatFailsIsItsStepsFailure) {
  ProjectContents contents = fresh();
  contents.project.consent = Consent::own;
  PipelineStatus pipeline;
  for (StageRecord& record : pipeline.records) record = {StageState::done, "0", 1, "Made.", {}};
  pipeline.job.state = JobState::failed;
  pipeline.job.error = Error{ErrorCode::no_face, "Clip 2 (wall.mp4): No face was found.", "Take it out.", ""};
  pipeline.failed = Stage::import;
  const auto steps = view_steps(&contents, false, pipeline, {}, {});
  EXPECT_EQ(at(steps, Step::check).state, StepState::failed);
  ASSERT_TRUE(at(steps, Step::check).error.has_value());
  EXPECT_EQ(at(steps, Step::check).error->what, pipeline.job.error->what);
  EXPECT_NE(at(steps, Step::face).state, StepState::failed);
}

TEST(ViewSteps, AnExportSaysWhatItWrote) {
  const ProjectContents contents = fresh();
  JobStatus exporting;
  exporting.state = JobState::running;
  exporting.fraction = 0.5;
  EXPECT_EQ(at(view_steps(&contents, false, {}, exporting, {}), Step::export_out).state, StepState::running);
  exporting.state = JobState::done;
  EXPECT_EQ(at(view_steps(&contents, false, {}, exporting, "/p/orbit-001.mp4"), Step::export_out).found,
            "orbit-001.mp4 is written.");
}

TEST(ViewSteps, WithoutAProjectNothingIsAtWork) {
  EXPECT_EQ(at(view_steps(nullptr, true, {}, {}, {}), Step::film).state, StepState::loading);
  EXPECT_EQ(at(view_steps(nullptr, false, {}, {}, {}), Step::film).state, StepState::to_do);
}

}  // namespace
}  // namespace likeness::ui
