// Claims about the studio's project, without a window: what its neighbours hear of it, and when.
#include "ui/studio/project_session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/base/files.h"
#include "core/project/staleness.h"
#include "tests/core/video/video_test_clip.h"
#include "tests/ui/studio/session_home.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;

class ProjectSessionTest : public testing::Test {
 protected:
  ProjectNeighbours neighbours() {
    ProjectNeighbours all;
    all.reading_begins = [this] { heard_.push_back("reading"); };
    all.was_read = [this](const ProjectReading& reading) {
      heard_.push_back(reading.first ? "first read" : "read");
      new_avatars_ += reading.new_avatar;
    };
    all.closing = [this] {
      heard_.push_back("closing");
      open_when_closing_ = home_.open.contents != nullptr;
    };
    all.run_begins = [this] { heard_.push_back("run begins"); };
    all.run_began = [this] { heard_.push_back("run began"); };
    all.are_working = [this] { return others_work_; };
    all.is_comparing = [this] { return others_work_; };
    return all;
  }
  bool until(const std::function<bool()>& so) {
    return home_.until([this] { session_.tick(); }, so);
  }
  void open() {
    session_.open(home_.project.folder());
    ASSERT_TRUE(until([this] { return home_.open.contents != nullptr; }));
    heard_.clear();
  }
  bool hears(const std::string& what) const { return std::ranges::find(heard_, what) != heard_.end(); }

  test::SessionHome home_;
  std::vector<std::string> heard_;
  int new_avatars_ = 0;
  bool open_when_closing_ = false, others_work_ = false;
  ProjectSession session_{home_.context, home_.open, neighbours()};
};

TEST_F(ProjectSessionTest, ReadingIsAnnouncedBeforeAndAfter) {
  session_.open(home_.project.folder());
  EXPECT_TRUE(session_.view().loading);
  ASSERT_TRUE(until([this] { return home_.open.contents != nullptr; }));
  EXPECT_EQ(heard_, (std::vector<std::string>{"closing", "reading", "first read"}));
  EXPECT_EQ(home_.shown.step, Step::direct) << "there is an avatar";
  EXPECT_EQ(home_.settings.recent.size(), 1u);
  session_.read_again();
  ASSERT_TRUE(until([this] { return hears("read"); }));
  EXPECT_EQ(heard_.size(), 5u);
  EXPECT_EQ(new_avatars_, 2) << "an avatar whose training is not recorded may be another";
}

// Its header is whole, so that the clip opens.
TEST_F(ProjectSessionTest, AClipWhosePicturesAreDamagedSaysSoAndWhatToDo) {
  const fs::path clip = home_.project.root / "clip.mp4";
  write_clip(clip, 64, 48, 10);
  auto bytes = read_file(clip);
  ASSERT_TRUE(bytes.ok());
  constexpr std::array kPictures{std::byte('m'), std::byte('d'), std::byte('a'), std::byte('t')};
  const auto pictures = std::ranges::search(*bytes, kPictures);
  ASSERT_FALSE(pictures.empty());
  std::fill(pictures.end(), bytes->end(), std::byte(0x5A));
  ASSERT_TRUE(write_file(clip, *bytes).ok());
  auto project = open_project(home_.project.folder());
  ASSERT_TRUE(project.ok());
  project->options.shared.video = clip;
  ASSERT_TRUE(save_project(*project).ok());

  open();
  ASSERT_TRUE(until([this] { return session_.view().clip_picture.number > 0; }));
  const FramePicture picture = session_.view().clip_picture;
  EXPECT_TRUE(home_.open.contents->clip.has_value()) << "it opens";
  EXPECT_EQ(picture.image, nullptr);
  EXPECT_NE(picture.missing.find("damaged after frame 0 of about 10"), std::string::npos) << picture.missing;
  EXPECT_NE(picture.missing.find("Copy it again"), std::string::npos) << picture.missing;
}

// As a look at the clip left it (tests/ui/studio_path_test.cpp has one to the end).
TEST_F(ProjectSessionTest, AKeptVerdictCountsUntilTheClipIsAnother) {
  const fs::path clip = home_.project.root / "bars.mp4";
  write_clip(clip, 64, 48, 40);
  auto project = open_project(home_.project.folder());
  ASSERT_TRUE(project.ok());
  project->options.shared.video = clip, project->consent = Consent::own;
  project->options.shared.landmark_model = "absent.dat";  // a look ends at once
  ASSERT_TRUE(save_project(*project).ok());
  CheckedClip kept{.clip_hash = *hash_video(clip)};
  kept.verdict = {.verdict = Verdict::refilm, .faceless = true};
  kept.facts.camera.evidence = "It rests.";
  ASSERT_TRUE(write_checked_clip(checked_clip_path(home_.project.folder()), kept).ok());
  open();
  EXPECT_EQ(session_.view().checking.state, JobState::none) << "it was looked at before";
  ASSERT_NE(session_.view().verdict, nullptr);
  EXPECT_TRUE(session_.view().verdict->faceless);
  EXPECT_EQ(session_.view().checked->camera.evidence, "It rests.");
  session_.close();
  EXPECT_EQ(session_.view().verdict, nullptr);
  // Another clip under the same name is looked at.
  write_clip(clip, 64, 48, 50);
  open();
  EXPECT_EQ(session_.view().verdict, nullptr);
  EXPECT_NE(session_.view().checking.state, JobState::none);
}

TEST_F(ProjectSessionTest, AnInterruptedTrainingIsShownWithTheTimeThatIsLeft) {
  write_clip(home_.project.root / "clip.mp4", 64, 48, 40);
  auto project = open_project(home_.project.folder());
  ASSERT_TRUE(project.ok());
  project->options.shared.video = home_.project.root / "clip.mp4";
  project->options.train.budget_s = 120;
  project->record(Stage::train) = {.state = StageState::stopped,
                                   .input_hash = input_hash(*project, Stage::train)};
  ASSERT_TRUE(save_project(*project).ok());
  TrainingCurve curve;
  curve.training = {{10, 45, 0.01, 20, 1000}, {20, 90, 0.01, 22, 1000}};
  ASSERT_TRUE(write_training_curve(training_curve_path(*project), curve).ok());
  ASSERT_TRUE(write_text(checkpoint_path(*project), "of step 20").ok());
  const auto seconds = [this] {
    const Plan& plan = home_.open.contents->plan;
    EXPECT_TRUE(plan.forecast.has_value());
    return std::pair(plan.seconds, plan.forecast->total_seconds());
  };
  open();
  EXPECT_EQ(home_.shown.step, Step::train);
  const auto [left, whole] = seconds();
  EXPECT_NEAR(left, whole - 0.75 * home_.open.contents->plan.forecast->seconds[std::size_t(Stage::train)],
              0.1);
  // Another choice, and the training begins anew.
  session_.close();
  project->options.train.use_latent = !project->options.train.use_latent;
  ASSERT_TRUE(save_project(*project).ok());
  open();
  EXPECT_NEAR(seconds().first, whole, 0.1);
}

// Two windows that save the same files: the later one would undo what was done in the other.
TEST_F(ProjectSessionTest, AProjectOfAnotherWindowIsAskedAboutAndOnlyLookedAt) {
  const std::string text = *read_text(home_.project.folder() / "project.json");
  auto others = std::make_unique<WindowLock>(home_.project.folder());
  EXPECT_FALSE(others->is_others());
  session_.open(home_.project.folder());
  ASSERT_TRUE(until([this] { return session_.view().elsewhere.has_value(); }));
  EXPECT_EQ(home_.open.contents, nullptr);
  session_.apply({.look_only = false});
  EXPECT_FALSE(session_.view().elsewhere.has_value());
  session_.open(home_.project.folder());
  ASSERT_TRUE(until([this] { return session_.view().elsewhere.has_value(); }));
  session_.apply({.look_only = true});
  ASSERT_TRUE(until([this] { return home_.open.contents != nullptr; }));
  EXPECT_TRUE(session_.view().look_only);
  session_.apply({.consent = Consent::own, .picture_size = 128});
  session_.make_avatar();
  session_.read_again();
  ASSERT_TRUE(until([this] { return !session_.view().loading; }));
  EXPECT_TRUE(session_.view().look_only);
  EXPECT_EQ(*read_text(home_.project.folder() / "project.json"), text);
  // Once the other is closed, this one has it.
  session_.close();
  others.reset();
  open();
  EXPECT_FALSE(session_.view().look_only);
  EXPECT_TRUE(WindowLock(home_.project.folder()).is_others());
  session_.close();
  // Once what was still to be saved is.
  EXPECT_TRUE(until([this] { return !WindowLock(home_.project.folder()).is_others(); }));
}

TEST_F(ProjectSessionTest, ClosingIsAnnouncedWhileTheProjectIsOpen) {
  open();
  session_.close();
  EXPECT_TRUE(open_when_closing_);
  EXPECT_EQ(home_.open.contents, nullptr);
  EXPECT_TRUE(home_.open.folder.empty());
  EXPECT_EQ(home_.shown.step, Step::film);
}

TEST_F(ProjectSessionTest, WhatArrivesForAClosedProjectIsDropped) {
  session_.open(home_.project.folder());
  session_.close();
  ASSERT_TRUE(until([this] { return !home_.background.busy(); }));
  home_.background.deliver();
  EXPECT_EQ(home_.open.contents, nullptr);
  EXPECT_FALSE(hears("first read"));
}

TEST_F(ProjectSessionTest, NobodyIsDeletedWhileOthersWork) {
  open();
  others_work_ = true;
  session_.apply({.delete_person = false});
  EXPECT_FALSE(session_.view().deleting);
  EXPECT_NE(home_.open.contents, nullptr);
  others_work_ = false;
  session_.apply({.delete_person = false});
  EXPECT_TRUE(session_.view().deleting);
  ASSERT_TRUE(until([this] { return !session_.view().deleting; }));
  EXPECT_FALSE(fs::exists(home_.project.folder()));
}

TEST_F(ProjectSessionTest, ARunBeginsOnlyWithItsChoicesSaved) {
  open();
  const fs::path file = home_.project.folder() / "project.json";
  const std::string text = *read_text(file);
  ASSERT_TRUE(write_text(file, "{").ok());
  session_.make_avatar();
  EXPECT_TRUE(home_.notices.error.has_value());
  EXPECT_TRUE(hears("run begins"));
  EXPECT_FALSE(hears("run began"));
  EXPECT_FALSE(session_.is_working());
  ASSERT_TRUE(write_text(file, text).ok());
  session_.make_avatar();
  EXPECT_TRUE(hears("run began"));
  session_.stop();
  EXPECT_FALSE(session_.goes_on());
  ASSERT_TRUE(until([this] { return !session_.is_working(); }));
}

TEST_F(ProjectSessionTest, WhatTheCameraDoesIsChosenSavedAndTakenBack) {
  open();
  const auto saved = [this] {
    const auto project = open_project(home_.project.folder());
    EXPECT_TRUE(project.ok());
    return project ? project->options.align.camera : std::nullopt;
  };
  const auto choose = [this](std::optional<CameraKind> kind) {
    ProjectRequests requests;
    requests.camera_kind = kind;
    session_.apply(requests);
  };
  const std::string before = input_hash(home_.open.contents->project, Stage::align);
  choose(CameraKind::handheld);
  EXPECT_EQ(saved(), CameraKind::handheld);
  EXPECT_NE(input_hash(home_.open.contents->project, Stage::align), before) << "the cameras are stale";
  choose(CameraKind::handheld);  // the same once more is no step
  choose(CameraKind::walking);
  EXPECT_EQ(saved(), CameraKind::walking);
  ASSERT_TRUE(session_.view().can_undo_camera);
  EXPECT_FALSE(session_.view().can_redo_camera);
  session_.undo_camera();
  EXPECT_EQ(saved(), CameraKind::handheld);
  session_.redo_camera();
  EXPECT_EQ(saved(), CameraKind::walking);
  session_.undo_camera();
  session_.undo_camera();
  EXPECT_EQ(saved(), std::nullopt);
  EXPECT_EQ(input_hash(home_.open.contents->project, Stage::align), before);
  EXPECT_FALSE(session_.view().can_undo_camera);
  choose(CameraKind::resting);
  EXPECT_FALSE(session_.view().can_redo_camera) << "another way was taken";
  // Another project knows nothing of it.
  session_.close();
  EXPECT_FALSE(session_.view().can_undo_camera);
}

TEST_F(ProjectSessionTest, NoSpanIsFittedAgainWhileMethodsAreCompared) {
  open();
  others_work_ = true;
  session_.apply({.refit = RefitSpan{1, 3}});
  ASSERT_TRUE(home_.notices.error.has_value());
  EXPECT_NE(home_.notices.error->fix.find("Stop the comparison"), std::string::npos);
  EXPECT_FALSE(hears("run begins"));
}

}  // namespace
}  // namespace likeness::ui
