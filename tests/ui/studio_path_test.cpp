// The whole path in a real window, by clicks alone: from the start screen to an exported picture.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/socket.h>

#include <algorithm>

#include "core/base/files.h"
#include "tests/ui/driven_studio.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;
using test::TestWindow;

class StudioPath : public test::DrivenStudio {
 protected:
  void SetUp() override {
    DrivenStudio::SetUp();
    options_.project.train.steps = 60;  // some seconds: longer than until the first preview
    options_.study = {.models = {"static-grid", kDefaultModel},
                      .steps = 60,
                      .size = 48,
                      .frames = 2,
                      .rays = 1024,
                      .baked_cells = {}};
    start();
  }
};

TEST_F(StudioPath, FromTheStartScreenToAnExportedPicture) {
  const fs::path calls = folder_ / "calls";
  ::setenv("LIKENESS_CALLS", calls.c_str(), 1);
  test::keep_shot("path_0_start");
  click("Try the demo");
  ASSERT_TRUE(until(300, [](const Snapshot& s) { return s.project.contents != nullptr; }))
      << "the demo was not filmed";
  EXPECT_EQ(studio_->snapshot().project.contents->project.consent, Consent::no_real_person);
  ASSERT_TRUE(until(5, [](const Snapshot& s) { return s.project.clip_picture.image != nullptr; }));
  EXPECT_GT(liveliness("clip picture"), 10);
  test::keep_shot("path_1_film");

  EXPECT_EQ(loop_->rest_s(), 0);
  click("Make the avatar");
  ASSERT_TRUE(studio_->is_working());
  EXPECT_TRUE(studio_->computes());
  // A pause keeps what is done; the same button goes on.
  ASSERT_TRUE(until(300, [](const Snapshot& s) {
    return s.project.pipeline.finished[std::size_t(Stage::import)] || !is_working(s.project.pipeline.job);
  }));
  ASSERT_TRUE(studio_->is_working()) << studio_->snapshot().project.pipeline.job.error.value_or(Error{}).what;
  click("Pause");
  // It waits where it is; the same place goes on.
  ASSERT_TRUE(until(20, [](const Snapshot& s) {
    return s.project.pipeline.job.waiting || !is_working(s.project.pipeline.job);
  }));
  const PipelineStatus paused = studio_->snapshot().project.pipeline;
  ASSERT_TRUE(is_working(paused.job)) << paused.job.error.value_or(Error{}).what;
  // Nothing to leave time to: the window is drawn as often as a hand moves.
  EXPECT_FALSE(studio_->computes());
  EXPECT_EQ(loop_->rest_s(), 0);
  test::keep_shot("path_2_paused");
  click("Continue");
  EXPECT_FALSE(studio_->snapshot().project.pipeline.job.paused);
  // A stop ends the work and keeps what is done.
  click("step Film");
  click("Stop");
  ASSERT_TRUE(until(20, [](const Snapshot& s) { return s.project.pipeline.job.state == JobState::stopped; }));
  ASSERT_TRUE(until(5, [](const Snapshot& s) { return s.step(Step::check).state == StepState::done; }));
  click("Continue");
  ASSERT_TRUE(until(400, [](const Snapshot& s) { return !is_working(s.project.pipeline.job); }));
  ASSERT_TRUE(until(10, [](const Snapshot& s) { return s.situation.finished && s.project.contents->avatar; }))
      << studio_->snapshot().project.pipeline.job.error.value_or(Error{}).what;
  EXPECT_EQ(studio_->snapshot().shown, Step::direct);
  EXPECT_FALSE(studio_->snapshot().project.pipeline.training.empty());
  EXPECT_NE(studio_->snapshot().project.pipeline.preview, nullptr);

  const auto rested = [](const Snapshot& s) {
    return s.direct.picture && s.direct.picture->last && !s.direct.rendering;
  };
  ASSERT_TRUE(until(120, rested));
  EXPECT_GT(liveliness("avatar view"), 10);
  test::keep_shot("path_6_direct");
  const Image straight = studio_->snapshot().direct.picture->rgba;

  const auto value = [this](const char* channel) {
    const DirectingView view = studio_->snapshot().direct.directing;
    return value_at(*view.performance, channel, view.playhead_s);
  };
  test::drag("##head yaw", 30, 0, 0, [this] { frame(); });
  EXPECT_GT(value("head yaw"), 1);
  click("Undo");
  EXPECT_EQ(*studio_->snapshot().direct.directing.performance, Performance{});
  click("Redo");
  EXPECT_GT(value("head yaw"), 1);
  // An avatar of so few steps hardly holds from the side: there a drag stops, and a second one goes on.
  test::drag("avatar view", 60, 0, 0, [this] { frame(); });
  const float stopped = value("camera yaw");
  EXPECT_LT(stopped, 0);
  test::drag("avatar view", 60, 0, 0, [this] { frame(); });
  EXPECT_LT(value("camera yaw"), std::min(stopped - 1, -5.f));
  ASSERT_TRUE(until(120, [&](const Snapshot& s) {
    return rested(s) && s.direct.picture->origin.moment == s.direct.moment;
  }));
  EXPECT_NE(studio_->snapshot().direct.picture->rgba.data, straight.data);
  const Performance directed = *studio_->snapshot().direct.directing.performance;

  for (const auto& view : std::vector<std::pair<const char*, const char*>>{{"Check", "check picture"},
                                                                           {"Cameras", "camera view"},
                                                                           {"Face", "face picture"},
                                                                           {"Train", "preview same"}}) {
    const char *const step = view.first, *const widget = view.second;
    click(std::string("step ") + step);
    ASSERT_TRUE(until(10, [&](const Snapshot&) { return noted_widgets().contains(widget); })) << step;
    EXPECT_GT(liveliness(widget), 5) << step;
    test::keep_shot(std::string("path_") + step);
  }
  // A span marked on the error strip is fitted again by itself, and taken back.
  click("step Face");
  const auto first = studio_->snapshot().project.contents->track;
  const Rectangle strip = noted_widgets().at("face strip");
  test::drag("face strip", 0.1f * (strip.high.x - strip.low.x), 0, 0, [this] { frame(); });
  click("Fit this span again");
  ASSERT_TRUE(until(300, [](const Snapshot& s) {
    return !is_working(s.project.pipeline.job) && !s.message.empty();
  })) << studio_->snapshot().error.value_or(Error{}).what;
  EXPECT_NE(studio_->snapshot().message.find("fitted again"), std::string::npos)
      << studio_->snapshot().message;
  ASSERT_TRUE(until(10, [](const Snapshot& s) { return s.project.contents->refits.size() == 1; }));
  EXPECT_EQ(studio_->snapshot().shown, Step::face);
  test::keep_shot("path_Face_refitted");
  click("Dismiss");
  click("Undo the re-fit");
  ASSERT_TRUE(until(20, [](const Snapshot& s) {
    return !is_working(s.project.pipeline.job) && s.situation.finished && s.project.contents->refits.empty();
  }));
  EXPECT_EQ(studio_->snapshot().project.contents->track->frames.size(), first->frames.size());
  click("Dismiss");
  click("step Train");
  EXPECT_GT(liveliness("training curve"), 5);
  // The card beside it: what it learnt, with the worst moments of the clip.
  ASSERT_NE(studio_->snapshot().project.contents->card, nullptr);
  EXPECT_GT(studio_->snapshot().project.contents->card->trained, 20);

  click("step Export");
  click("Export a still");
  ASSERT_TRUE(until(120, [](const Snapshot& s) { return !s.exports.written.empty(); }));
  const auto still = read_image(studio_->snapshot().exports.written);
  ASSERT_TRUE(still.ok()) << still.error().what;
  EXPECT_EQ(still->width, 256);
  test::keep_shot("path_7_export");

  // For those who want it: the same capture learnt by another method. Stopped, it goes on where it was.
  click("menu Avatar");
  click("item Compare with other methods...");
  ASSERT_TRUE(until(10, [](const Snapshot& s) { return s.study.open && s.study.forecast; }));
  EXPECT_EQ(studio_->snapshot().shown, Step::train);
  EXPECT_EQ(studio_->snapshot().study.missing, "");
  EXPECT_EQ(studio_->snapshot().study.forecast->trainings, 2);
  EXPECT_EQ(studio_->snapshot().study.finished, nullptr);
  test::keep_shot("path_study_before");
  click("Start the comparison");
  EXPECT_TRUE(studio_->is_working());
  EXPECT_FALSE(studio_->snapshot().situation.running);
  const fs::path comparison = folder_ / "projects" / "demo.likeness" / "comparison";
  ASSERT_TRUE(until(300, [&](const Snapshot& s) {
    return fs::exists(comparison / "static-grid-0.json") || !is_working(s.study.job);
  }));
  ASSERT_TRUE(is_working(studio_->snapshot().study.job))
      << studio_->snapshot().study.job.error.value_or(Error{}).what;
  test::keep_shot("path_study_running");
  click("Stop the comparison");
  ASSERT_TRUE(until(300, [](const Snapshot& s) { return !is_working(s.study.job); }));
  EXPECT_EQ(studio_->snapshot().study.job.state, JobState::stopped);
  ASSERT_TRUE(
      until(10, [](const Snapshot& s) { return s.study.forecast && s.study.forecast->finished == 1; }));
  const auto kept = fs::last_write_time(comparison / "static-grid-0.json");
  click("Start the comparison");  // it says: go on
  ASSERT_TRUE(until(300, [](const Snapshot& s) { return s.study.finished != nullptr; }))
      << studio_->snapshot().study.job.error.value_or(Error{}).what;
  EXPECT_EQ(fs::last_write_time(comparison / "static-grid-0.json"), kept);
  EXPECT_TRUE(fs::exists(comparison / "report.html"));
  EXPECT_EQ(studio_->snapshot().study.finished->summary.tables.at(0).rows.size(), 2u);
  frame();
  frame();
  EXPECT_GT(liveliness("study table models"), 5);
  EXPECT_GT(liveliness("study plot 0"), 5);
  EXPECT_TRUE(noted_widgets().contains("Show the comparison's folder"));
  test::keep_shot("path_study_done");
  click("Back to the training");
  EXPECT_GT(liveliness("training curve"), 5);
  click("step Export");

  // What the look at the clip found is kept, and not found anew at each opening.
  ASSERT_TRUE(until(60, [](const Snapshot& s) { return !is_working(s.project.checking); }));
  EXPECT_TRUE(fs::exists(folder_ / "projects" / "demo.likeness" / "check.json"));

  // Started again, the project is among the recent ones and opens where it can be directed.
  start();
  click("recent demo.likeness");
  ASSERT_TRUE(until(20, [](const Snapshot& s) { return s.project.contents && s.project.contents->avatar; }));
  EXPECT_EQ(studio_->snapshot().shown, Step::direct);
  // What was directed is still there, and is the command line's file.
  ASSERT_TRUE(until(5, [&](const Snapshot& s) { return *s.direct.directing.performance == directed; }));
  const auto file = read_performance(folder_ / "projects" / "demo.likeness" / "performance.json");
  ASSERT_TRUE(file.ok()) << file.error().what;
  EXPECT_EQ(*file, directed);
  // The curve of its training is there, too.
  EXPECT_GE(studio_->snapshot().project.curve.training.size(), 2u);
  click("step Train");
  EXPECT_GT(liveliness("training curve"), 5);
  test::keep_shot("path_8_reopened");

  // Everything of the person goes when asked for, and only after the question.
  const fs::path folder = studio_->snapshot().project.contents->project.folder;
  const fs::path clip = studio_->snapshot().project.contents->project.options.shared.video;
  const auto ask = [&] {
    TestWindow::get().shell->ask(Question::delete_person);
    frame();
  };
  ask();
  click("Keep the person");
  EXPECT_TRUE(fs::exists(folder / "avatar.bin"));
  ask();
  frame();
  test::keep_shot("path_9_delete");
  click("Delete all, exports too");
  ASSERT_TRUE(until(10, [](const Snapshot& s) { return !s.project.contents && !s.project.deleting; }));
  EXPECT_FALSE(fs::exists(folder));
  EXPECT_TRUE(fs::exists(clip));
  EXPECT_TRUE(studio_->snapshot().settings.recent.empty());
  // In all of that nobody was called over a network (tests/support/watch_connect.cpp).
  EXPECT_FALSE(fs::exists(calls)) << *read_text(calls);
  (void)::socket(AF_INET, SOCK_STREAM, 0);
  EXPECT_TRUE(fs::exists(calls)) << "nobody watches";
}

TEST_F(StudioPath, AFileThatIsNotAVideoIsRefusedWithARemedy) {
  const fs::path file = folder_ / "notes.mp4";
  ASSERT_TRUE(write_text(file, "no video").ok());
  TestWindow::get().window->drop({file});
  ASSERT_TRUE(until(10, [](const Snapshot& s) { return s.error.has_value(); }));
  EXPECT_FALSE(studio_->snapshot().error->fix.empty());
  EXPECT_EQ(studio_->snapshot().project.contents, nullptr);
  click("Dismiss");
  EXPECT_FALSE(studio_->snapshot().error.has_value());
}

}  // namespace
}  // namespace likeness::ui
