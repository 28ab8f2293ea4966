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
