// Claims about the studio's state, without a window: requests go in, work is done, snapshots come out.
#include "ui/studio/studio.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "core/base/files.h"
#include "core/capture/capture.h"
#include "core/video/encode.h"
#include "tests/core/export/tiny_project.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;

class StudioState : public testing::Test {
 protected:
  void SetUp() override {
    clip_ = project_.root / "clip.mp4";
    auto writer = VideoWriter::create(clip_, 64, 48);
    ASSERT_TRUE(writer.ok());
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer->add(Image8(64, 48, 3, std::uint8_t(40 * i))).ok());
    ASSERT_TRUE(writer->finish().ok());
    auto stored = open_project(project_.folder());
    ASSERT_TRUE(stored.ok());
    stored->options.shared.video = clip_;
    stored->consent = Consent::given;
    ASSERT_TRUE(save_project(*stored).ok());
    studio_ = std::make_unique<Studio>(
        StudioOptions{.settings = project_.root / "studio.json", .projects = project_.root}, [] {});
  }

  // False where it does not come to be so in time.
  bool until(const std::function<bool(const Snapshot&)>& so) {
    for (int i = 0; i < 4000; ++i) {
      studio_->tick();
      if (so(studio_->snapshot())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }
  void ask(Requests requests) { studio_->apply(requests); }
  void ask(Command command) {
    Requests requests;
    requests.ask(command);
    studio_->apply(requests);
  }
  // The head turned at the start.
  static Performance directed(float yaw_deg) {
    Performance performance;
    performance.channels["head yaw"] = {{0, yaw_deg}};
    return performance;
  }
  void edit(Performance performance) {
    Requests requests;
    requests.direct.edit(std::move(performance), "turn");
    requests.direct.finished = true;
    ask(requests);
  }
  void open() {
    Requests requests;
    requests.open = project_.folder();
    ask(requests);
    ASSERT_TRUE(
        until([](const Snapshot& s) { return s.project.contents != nullptr && s.project.contents->avatar; }));
  }

  likeness::test::TinyProject project_;
  fs::path clip_;
  std::unique_ptr<Studio> studio_;
};

TEST_F(StudioState, ExportsTakeTurnsAndAFailureIsSurvived) {
  open();
  Requests wanted;
  wanted.exports.choice = ExportChoice{.ground = ExportGround::dark};
  wanted.ask(Command::export_still);
  wanted.ask(Command::export_mesh);
  ask(wanted);
  // A still before a picture that is gone when its turn comes.
  const fs::path wall = project_.root / "wall.png";
  ASSERT_TRUE(write_text(wall, "no picture").ok());
  wanted = {};
  wanted.exports.choice = ExportChoice{.ground = ExportGround::picture, .picture = wall};
  wanted.ask(Command::export_still);
  wanted.ask(Command::export_mesh);
  ask(wanted);
  ASSERT_TRUE(until([](const Snapshot& s) { return !s.situation.exporting; }));
  const auto exports = studio_->snapshot().exports.items;
  ASSERT_EQ(exports.size(), 4u);
  EXPECT_EQ(exports[0].status.state, JobState::done);
  EXPECT_EQ(exports[1].status.state, JobState::done);
  EXPECT_EQ(exports[2].status.state, JobState::failed);
  EXPECT_EQ(exports[3].status.state, JobState::done);
  EXPECT_TRUE(fs::exists(project_.folder() / "exports" / "head-002.glb"));
  EXPECT_NE(exports[0].out, exports[2].out);
}

// Of a file system's 255 bytes the clip's name takes 253, and the project's adds to it.
TEST_F(StudioState, AClipWithALongNameBecomesAProject) {
  std::string name;
  while (name.size() < 248) name += "\u5c71";
  name += "x.mp4";  // 253 or 254
  const fs::path clip = project_.root / name;
  fs::copy_file(clip_, clip);
  Requests requests;
  requests.open = clip;
  ask(requests);
  ASSERT_TRUE(until([](const Snapshot& s) { return s.project.contents || s.error; }));
  ASSERT_FALSE(studio_->snapshot().error) << studio_->snapshot().error->what;
  const std::string folder = studio_->folder().filename().string();
  EXPECT_LE(folder.size(), 255u);
  EXPECT_TRUE(folder.ends_with("\u5c71.likeness")) << folder;
  EXPECT_EQ(studio_->snapshot().project.contents->project.options.shared.video, clip);
}

// A home that may only be read: nothing asks for the command line.
TEST_F(StudioState, WhereNewProjectsCannotGoAnotherFolderIsChosenAndTheClipGoesOn) {
  const fs::path taken = project_.root / "taken";
  ASSERT_TRUE(write_text(taken, "a file").ok());
  const StudioOptions options{.settings = project_.root / "studio.json", .projects = taken / "Likeness"};
  studio_ = std::make_unique<Studio>(options, [] {});
  Requests requests;
  requests.open = clip_;
  ask(requests);
  ASSERT_TRUE(until([](const Snapshot& s) { return s.error.has_value(); }));
  EXPECT_TRUE(studio_->snapshot().projects_refuse);
  requests = {};
  requests.ask(Command::choose_projects);
  EXPECT_EQ(studio_->apply(requests), WindowRequest::pick_projects);
  requests = {};
  requests.projects = taken / "no better";
  ask(requests);
  EXPECT_TRUE(studio_->snapshot().error);
  requests.projects = project_.root / "elsewhere";
  ask(requests);
  ASSERT_TRUE(until([](const Snapshot& s) { return s.project.contents != nullptr; }));
  const Snapshot now = studio_->snapshot();
  EXPECT_FALSE(now.error);
  EXPECT_FALSE(now.projects_refuse);
  EXPECT_EQ(now.project.contents->project.folder, project_.root / "elsewhere" / "clip.likeness");
  EXPECT_EQ(now.projects, project_.root / "elsewhere");
  EXPECT_EQ(read_settings(options.settings).projects, now.projects) << "and it stays so";
}

// What goes wrong elsewhere is not the fault of the folder of new projects.
TEST_F(StudioState, AnotherFailureOffersNoOtherFolder) {
  Requests requests;
  requests.open = project_.root / "absent.mp4";
  ask(requests);
  ASSERT_TRUE(until([](const Snapshot& s) { return s.error.has_value(); }));
  EXPECT_FALSE(studio_->snapshot().projects_refuse);
}

TEST_F(StudioState, StoppedWorkGoesOnOnlyWithSomethingNew) {
  open();
  EXPECT_FALSE(studio_->goes_on());
  ask(Command::export_mesh);
  ask(Command::export_mesh);
  studio_->stop_work();
  EXPECT_FALSE(studio_->goes_on());
  ask(Command::export_mesh);
  EXPECT_TRUE(studio_->goes_on());
  ASSERT_TRUE(until([](const Snapshot& s) { return !s.situation.exporting; }));
  EXPECT_FALSE(studio_->goes_on());
}

// The tiny project has an avatar but no track: nothing that another method could learn from.
TEST_F(StudioState, AComparisonSaysWhatIsToBeDoneFirst) {
  open();
  EXPECT_FALSE(studio_->snapshot().study.open);
  ask(Command::compare_methods);
  const Snapshot s = studio_->snapshot();
  EXPECT_TRUE(s.study.open);
  EXPECT_EQ(s.shown, Step::train);
  EXPECT_NE(s.study.missing.find("Make the avatar first"), std::string::npos) << s.study.missing;
  EXPECT_FALSE(s.situation.can_study);
  ask(Command::start_study);
  EXPECT_FALSE(studio_->is_working());
  // Another choice is estimated again; without any table there is nothing to estimate.
  ASSERT_TRUE(until([](const Snapshot& now) { return now.study.forecast.has_value(); }));
  const double once = studio_->snapshot().study.forecast->seconds;
  Requests wanted;
  wanted.study.choice = StudyChoice{.tables = {"models"}, .seconds = 300, .seeds = 3};
  ask(wanted);
  ASSERT_TRUE(until(
      [&](const Snapshot& now) { return now.study.forecast && now.study.forecast->seconds > 2 * once; }));
  wanted.study.choice = StudyChoice{.tables = {}};
  ask(wanted);
  EXPECT_FALSE(studio_->snapshot().study.forecast.has_value());
  // The path leads back.
  wanted = {};
  wanted.show = Step::train;
  ask(wanted);
  EXPECT_FALSE(studio_->snapshot().study.open);
}

TEST_F(StudioState, WhatAnExportLacksIsSaidAtOnce) {
  open();
  ask(Command::export_driven);
  EXPECT_TRUE(studio_->snapshot().exports.items.empty());
  ASSERT_TRUE(studio_->snapshot().error.has_value());
  EXPECT_FALSE(studio_->snapshot().error->fix.empty());
}

TEST_F(StudioState, AMovedClipIsFoundAgainAndAnotherOneRefused) {
  const fs::path moved = project_.root / "moved.mp4";
  fs::rename(clip_, moved);
  open();
  EXPECT_TRUE(studio_->snapshot().situation.clip_missing);
  EXPECT_EQ(studio_->snapshot().step(Step::film).next, "Say where it is now: Find the clip.");
  Requests requests;
  requests.project.relink = project_.root / "absent.mp4";
  ask(requests);
  ASSERT_TRUE(until([](const Snapshot& s) { return s.error.has_value(); }));
  requests.project.relink = moved;
  ask(requests);
  ASSERT_TRUE(until([](const Snapshot& s) { return s.project.contents->clip.has_value(); }));
  EXPECT_FALSE(studio_->snapshot().situation.clip_missing);
  EXPECT_EQ(open_project(project_.folder())->options.shared.video, moved);
}

TEST_F(StudioState, AFurtherClipIsAddedMakesTheAvatarOldAndIsTakenOut) {
  open();
  const fs::path second = project_.root / "second.mp4";
  auto writer = VideoWriter::create(second, 64, 48);
  ASSERT_TRUE(writer.ok());
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer->add(Image8(64, 48, 3, std::uint8_t(200 - 40 * i))).ok());
  ASSERT_TRUE(writer->finish().ok());
  Requests wanted;
  wanted.project.add_clip = second;
  wanted.project.budget_s =
      900;  // asked for while the list is being written: must not write the old one over it
  ask(wanted);
  ASSERT_TRUE(
      until([](const Snapshot& s) { return s.project.contents && s.project.contents->further.size() == 1; }));
  EXPECT_EQ(studio_->snapshot().project.contents->further[0].name, "second.mp4");
  EXPECT_EQ(studio_->snapshot().project.contents->further[0].state, StageState::to_do);
  EXPECT_EQ(open_project(project_.folder())->further_clips, std::vector<int>{2});
  EXPECT_FALSE(studio_->snapshot().project.contents->is_current(Stage::train));
  EXPECT_FALSE(studio_->snapshot().message.empty());
  wanted = {};
  wanted.project.add_clip = second;
  ask(wanted);
  ASSERT_TRUE(until([](const Snapshot& s) { return s.error.has_value(); }));
  wanted = {};
  wanted.dismiss_error = true;
  wanted.project.remove_clip = 2;
  ask(wanted);
  ASSERT_TRUE(
      until([](const Snapshot& s) { return s.project.contents && s.project.contents->further.empty(); }));
  EXPECT_TRUE(fs::exists(second));
  EXPECT_TRUE(open_project(project_.folder())->further_clips.empty());
}

TEST_F(StudioState, WhatACommandLineChoseMeanwhileStays) {
  open();
  ASSERT_TRUE(change_project(project_.folder(), [](Project& p) { p.options.train.left_out = {3}; }).ok());
  Requests wanted;
  wanted.project.budget_s = 900;
  ask(wanted);
  const auto stored = open_project(project_.folder());
  ASSERT_TRUE(stored.ok());
  EXPECT_EQ(stored->options.train.budget_s, 900);
  EXPECT_EQ(stored->options.train.left_out, std::vector<int>{3});
}

TEST_F(StudioState, TheRestingFaceIsKeptInTheProjectAndTakenBack) {
  Capture capture;
  capture.video = clip_;
  capture.width = capture.height = 64;
  capture.frames_per_second = 25;
  capture.crop = {0, 0, 64};
  for (int frame = 0; frame < 5; ++frame) capture.frames.push_back({.frame = frame, .used = true});
  ASSERT_TRUE(write_capture(capture_path({.folder = project_.folder()}), capture).ok());
  open();
  Requests wanted;
  wanted.project.rest_frames = std::vector{3};
  ask(wanted);
  EXPECT_FALSE(studio_->snapshot().error.has_value()) << studio_->snapshot().error->what;
  EXPECT_EQ(open_project(project_.folder())->options.fit.rest_frames, std::vector<int>{3});
  wanted.project.rest_frames = std::vector<int>{};
  ask(wanted);
  EXPECT_TRUE(open_project(project_.folder())->options.fit.rest_frames.empty());
}

TEST_F(StudioState, ATrainingThatWasFinishedEarlyIsNotTheMeasureOfTheNext) {
  ASSERT_TRUE(change_project(project_.folder(), [](Project& p) {
                p.options.train.budget_s = 52, p.options.train.full_budget_s = 600, p.options.train.steps = 0;
                p.consent = Consent::own;
              }).ok());
  open();
  ask(Command::make_avatar);
  const auto stored = open_project(project_.folder());
  ASSERT_TRUE(stored.ok());
  EXPECT_EQ(stored->options.train.budget_s, 600);
  EXPECT_EQ(stored->options.train.full_budget_s, 0);
}

TEST_F(StudioState, ADeletedPersonIsGoneAndForgotten) {
  open();
  EXPECT_FALSE(studio_->snapshot().settings.recent.empty());
  Requests requests;
  requests.project.delete_person = false;
  ask(requests);
  EXPECT_EQ(studio_->snapshot().project.contents, nullptr);
  ASSERT_TRUE(until([](const Snapshot& s) { return !s.project.deleting; }));
  EXPECT_FALSE(fs::exists(project_.folder()));
  EXPECT_TRUE(fs::exists(clip_));
  EXPECT_TRUE(studio_->snapshot().settings.recent.empty());
}

TEST_F(StudioState, AProjectIsOpenedByItsFolderOrByWhatIsInIt) {
  for (const fs::path& path : {project_.folder(), project_.folder() / "", project_.folder() / "project.json",
                               project_.folder() / "avatar.bin"}) {
    Requests requests;
    requests.open = path;
    ask(requests);
    ASSERT_TRUE(until([](const Snapshot& s) {
      return s.project.contents != nullptr && s.project.contents->avatar;
    })) << path;
    EXPECT_TRUE(fs::equivalent(studio_->folder(), project_.folder()));
    EXPECT_EQ(studio_->snapshot().settings.recent.size(), 1u) << path << " is another project on the list";
    ask(Command::close_project);
  }
}

TEST_F(StudioState, ADamagedProjectIsDeletedFromTheWindow) {
  open();
  ask(Command::close_project);
  ASSERT_TRUE(write_text(project_.folder() / "project.json", "{\"program\": \"Likeness\", ").ok());
  Requests requests;
  requests.open = project_.folder();
  ask(requests);
  ASSERT_TRUE(until([](const Snapshot& s) { return s.project.damaged.has_value(); }));
  EXPECT_TRUE(studio_->snapshot().error.has_value());
  EXPECT_FALSE(studio_->snapshot().settings.recent.empty()) << "it could not be found again";
  EXPECT_TRUE(is_enabled(Command::delete_person, studio_->snapshot().situation));
  requests = {};
  requests.project.delete_person = false;
  ask(requests);
  EXPECT_FALSE(studio_->snapshot().error.has_value());
  ASSERT_TRUE(until([](const Snapshot& s) { return !s.project.deleting; }));
  EXPECT_FALSE(fs::exists(project_.folder()));
  EXPECT_TRUE(fs::exists(clip_));
  EXPECT_FALSE(studio_->snapshot().project.damaged.has_value());
  EXPECT_TRUE(studio_->snapshot().settings.recent.empty());
}

TEST_F(StudioState, ADamagedProjectIsRepairedFromTheWindow) {
  const std::string text = *read_text(project_.folder() / "project.json");
  ASSERT_TRUE(write_text(project_.folder() / "project.json", text.substr(0, text.size() - 9)).ok());
  Requests requests;
  requests.open = project_.folder();
  ask(requests);
  ASSERT_TRUE(until([](const Snapshot& s) { return s.project.damaged.has_value(); }));
  ask(Command::repair_project);
  ASSERT_TRUE(until([](const Snapshot& s) { return s.project.contents && s.project.contents->avatar; }));
  const Snapshot now = studio_->snapshot();
  EXPECT_FALSE(now.error.has_value());
  EXPECT_FALSE(now.project.damaged.has_value());
  EXPECT_EQ(now.project.contents->project.options.shared.video, clip_);
  EXPECT_EQ(now.project.contents->project.consent, Consent::not_asked);
}

TEST_F(StudioState, ABuildIsForecastBeforeItStarts) {
  open();
  const Plan& plan = studio_->snapshot().project.contents->plan;
  ASSERT_TRUE(plan.forecast.has_value());
  EXPECT_EQ(plan.forecast->frames, 5);
  EXPECT_GT(plan.seconds, 0);
  const double before = plan.seconds;
  Requests longer;
  longer.project.budget_s = 3600;
  ask(longer);
  ASSERT_TRUE(until([&](const Snapshot& s) { return s.project.contents->plan.seconds > before + 3000; }));
}

TEST_F(StudioState, TheLastEditIsWrittenLast) {
  open();
  const Performance first = directed(5);
  edit(first);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  studio_->tick();  // begins to write the first
  const Performance last = directed(9);
  edit(last);
  studio_.reset();
  const auto kept = read_performance(project_.folder() / "performance.json");
  ASSERT_TRUE(kept.ok());
  EXPECT_EQ(*kept, last);
}

TEST_F(StudioState, APerformanceThatCouldNotBeWrittenIsWrittenLater) {
  open();
  const fs::path file = project_.folder() / "performance.json";
  fs::create_directory(file);  // in its way
  edit(directed(5));
  ASSERT_TRUE(until([](const Snapshot& s) { return s.error.has_value(); }));
  fs::remove(file);
  ASSERT_TRUE(until([&](const Snapshot&) { return fs::is_regular_file(file); }));
  EXPECT_EQ(*read_performance(file), directed(5));
}

TEST_F(StudioState, StepsEndWhereThePathDoes) {
  open();
  for (int i = 0; i < 9; ++i) ask(Command::next_step);
  EXPECT_EQ(studio_->snapshot().shown, Step::export_out);
  ask(Command::previous_step);
  EXPECT_EQ(studio_->snapshot().shown, Step::direct);
  for (int i = 0; i < 9; ++i) ask(Command::previous_step);
  EXPECT_EQ(studio_->snapshot().shown, Step::film);
}

TEST_F(StudioState, UndoIsOfWhatIsShown) {
  open();
  edit(directed(5));
  edit(directed(9));
  ask(Command::undo);
  EXPECT_EQ(*studio_->snapshot().direct.directing.performance, directed(5));
  ask(Command::previous_step);
  ASSERT_NE(studio_->snapshot().shown, Step::direct);
  ask(Command::undo);  // nothing that can be undone is in sight
  EXPECT_EQ(*studio_->snapshot().direct.directing.performance, directed(5));
}

TEST_F(StudioState, TheWindowIsAskedForWhatOnlyItCanDo) {
  const auto asked = [this](Command command) {
    Requests requests;
    requests.ask(command);
    return studio_->apply(requests);
  };
  EXPECT_EQ(asked(Command::open_clip), WindowRequest::pick_clip);
  EXPECT_EQ(asked(Command::save_performance), WindowRequest::none) << "there is no performance";
  open();
  EXPECT_EQ(asked(Command::save_performance), WindowRequest::name_performance);
  EXPECT_EQ(asked(Command::toggle_theme), WindowRequest::none);
  EXPECT_EQ(asked(Command::quit), WindowRequest::quit);
}

TEST_F(StudioState, TheScaleHasLimits) {
  open();
  for (int i = 0; i < 20; ++i) ask(Command::larger);
  EXPECT_EQ(studio_->snapshot().settings.scale_percent, kMostScale);
  for (int i = 0; i < 20; ++i) ask(Command::smaller);
  EXPECT_EQ(studio_->snapshot().settings.scale_percent, kLeastScale);
}

}  // namespace
}  // namespace likeness::ui
