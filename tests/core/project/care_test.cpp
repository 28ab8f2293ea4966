// Claims about the care for a project: what is deleted and what never is, whose clip is taken for the same,
// and which frames can be left out.
#include "core/project/care.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/capture/capture.h"
#include "core/project/project_views.h"
#include "core/project/run_stages.h"
#include "core/project/staleness.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class Care : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_care_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    clip_ = root_ / "clip.mp4";
    folder_ = root_ / "me.likeness";
    ASSERT_TRUE(write_text(clip_, "the clip").ok());
    ProjectOptions options;
    options.shared.video = clip_;
    ASSERT_TRUE(open_or_create_project(folder_, options).ok());
    for (const char* file : {"frames/000000.png",
                             "masks/000000.png",
                             "regions/000000.png",
                             "colmap/database.db",
                             "avatar.bin",
                             "checkpoint.bin",
                             "track.json",
                             "cameras.json",
                             "plate.png",
                             "plate_known.png",
                             "plate.json",
                             "matte_report.json",
                             "training_curve.json",
                             "check.json",
                             "track_first.json",
                             "detail.npz",
                             "room.bin",
                             "attribute_values.json",
                             "attribute_values.next.json",
                             "refits.json",
                             "performance.json",
                             "performance-1.json",
                             ".avatar.12-3.part.bin",
                             "masks.part/000000.png",
                             "regions.old/000000.png",
                             "corrections/000000.json",
                             "corrections/000001.damaged.json",
                             "corrections.old/000000.json",
                             "corrections-2.old/000000.json",
                             "comparison/report.html",
                             "exports/orbit-001.mp4"})
      ASSERT_TRUE(write_text(folder_ / file, "x").ok());
    write_import(clip_);
  }
  void TearDown() override { fs::remove_all(root_); }

  // As an import of this clip would have left it: frames 0 to 9, the last of them held out.
  void write_import(const fs::path& clip) {
    Capture capture;
    capture.video = clip;
    capture.video_hash = *hash_file(clip);
    capture.width = capture.height = 64, capture.crop = {0, 0, 64}, capture.frames_per_second = 25;
    for (int i = 0; i < 10; ++i) capture.frames.push_back({i, i / 25.0, 100, i == 9, i != 9, ""});
    ASSERT_TRUE(write_capture(folder_ / "capture.json", capture).ok());
  }

  fs::path root_, clip_, folder_;
};

TEST_F(Care, ADeletedPersonLeavesTheClipAndNothingElse) {
  const auto deleted = delete_person(folder_, false);
  ASSERT_TRUE(deleted.ok()) << deleted.error().what;
  EXPECT_TRUE(deleted->folder_gone);
  EXPECT_GT(deleted->bytes, 10u);
  EXPECT_FALSE(fs::exists(folder_));
  EXPECT_EQ(*read_text(clip_), "the clip");
  EXPECT_NE(deletion_words(*deleted).find("The clip stays"), std::string::npos);
  EXPECT_NE(deletion_words(*deleted).find(clip_.string()), std::string::npos);
}

TEST_F(Care, StrokesGoWithThePersonWhateverElseIsKept) {
  ASSERT_TRUE(write_text(folder_ / "notes.txt", "mine").ok());
  ASSERT_TRUE(delete_person(folder_, true).ok());
  EXPECT_FALSE(fs::exists(folder_ / "corrections"));
  EXPECT_FALSE(fs::exists(folder_ / "corrections.old"));
  EXPECT_FALSE(fs::exists(folder_ / "corrections-2.old"));
  EXPECT_TRUE(fs::exists(folder_ / "notes.txt"));
}

TEST_F(Care, ExportsAndForeignFilesAreKeptWhereAsked) {
  ASSERT_TRUE(write_text(folder_ / "notes.txt", "mine").ok());
  const auto deleted = delete_person(folder_, true);
  ASSERT_TRUE(deleted.ok()) << deleted.error().what;
  EXPECT_FALSE(deleted->folder_gone);
  EXPECT_EQ(deleted->kept.size(), 2u);
  EXPECT_TRUE(fs::exists(folder_ / "exports/orbit-001.mp4"));
  EXPECT_EQ(*read_text(folder_ / "notes.txt"), "mine");
  EXPECT_FALSE(fs::exists(folder_ / "frames"));
  EXPECT_FALSE(fs::exists(folder_ / "avatar.bin"));
  EXPECT_FALSE(fs::exists(folder_ / "project.json"));
}

TEST_F(Care, AClipInsideTheFolderIsNeverDeleted) {
  // Even where it bears the name of something that goes.
  for (const char* inside : {"clip.mp4", "frames/clip.mp4"}) {
    fs::create_directories(folder_ / "frames");
    ASSERT_TRUE(write_text(folder_ / inside, "the clip").ok());
    Project project;
    project.folder = folder_;
    project.options.shared.video = folder_ / inside;
    ASSERT_TRUE(save_project(project).ok());
    const auto deleted = delete_person(folder_, false);
    ASSERT_TRUE(deleted.ok()) << deleted.error().what;
    EXPECT_FALSE(deleted->folder_gone);
    EXPECT_EQ(*read_text(folder_ / inside), "the clip") << inside;
  }
}

TEST_F(Care, ALinkInTheFolderIsRemovedButNotWhatItPointsTo) {
  ASSERT_TRUE(write_text(root_ / "pictures" / "a.png", "kept").ok());
  fs::remove_all(folder_ / "frames");
  fs::create_directory_symlink(root_ / "pictures", folder_ / "frames");
  ASSERT_TRUE(delete_person(folder_, false).ok());
  EXPECT_EQ(*read_text(root_ / "pictures" / "a.png"), "kept");
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(Care, WhatIsAtWorkOrNoProjectIsNotDeleted) {
  const auto project = open_project(folder_);
  ASSERT_TRUE(project.ok());
  {
    const auto lock = ProjectLock::acquire(*project);
    ASSERT_TRUE(lock.ok());
    const auto busy = delete_person(folder_, false);
    ASSERT_FALSE(busy.ok());
    EXPECT_TRUE(fs::exists(folder_ / "avatar.bin"));
  }
  ASSERT_TRUE(write_text(root_ / "other" / "avatar.bin", "x").ok());
  EXPECT_FALSE(delete_person(root_ / "other", false).ok());
  EXPECT_TRUE(fs::exists(root_ / "other" / "avatar.bin"));
}

TEST_F(Care, AMovedClipIsMissedAndFoundAgain) {
  EXPECT_FALSE(missing_clip(*open_project(folder_)).has_value());
  const fs::path moved = root_ / "holiday.mp4";
  fs::rename(clip_, moved);
  const auto missing = missing_clip(*open_project(folder_));
  ASSERT_TRUE(missing.has_value());
  EXPECT_NE(missing->fix.find("likeness relink"), std::string::npos);
  ASSERT_TRUE(write_text(root_ / "other.mp4", "another clip").ok());
  const auto other = relink_clip(folder_, root_ / "other.mp4");
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().code, ErrorCode::bad_input);
  EXPECT_FALSE(relink_clip(folder_, root_ / "absent.mp4").ok());
  const auto linked = relink_clip(folder_, moved);
  ASSERT_TRUE(linked.ok()) << linked.error().what;
  EXPECT_EQ(open_project(folder_)->options.shared.video, moved);
  EXPECT_FALSE(missing_clip(*open_project(folder_)).has_value());
}

TEST_F(Care, AStageThatNeedsTheMissingClipSaysHowToFindIt) {
  auto project = open_project(folder_);
  fs::remove(clip_);
  const auto outcome = run_stages(*project, Stage::import, Progress(), {}, {});
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(outcome.error().code, ErrorCode::not_found);
  EXPECT_NE(outcome.error().fix.find("relink"), std::string::npos);
}

TEST_F(Care, NothingIsWrittenOverAClipOrWhatTheProjectKeeps) {
  const Project project = *open_project(folder_);
  for (const fs::path& taken :
       {clip_, root_ / "." / "clip.mp4", folder_ / "frames", folder_ / "frames" / "000000.png",
        folder_ / "track.json", folder_ / "performance.json", folder_ / "comparison" / "pictures"}) {
    const auto refused = check_free(project, taken, "--pictures");
    ASSERT_FALSE(refused.ok()) << taken;
    EXPECT_NE(refused.error().fix.find("--pictures"), std::string::npos);
  }
  for (const fs::path& free :
       {root_ / "film.mp4", folder_ / "exports" / "film.mp4", folder_ / "performance-7.json",
        root_ / "frames", fs::path("track.json"), root_ / "other.likeness" / "frames" / "000000.png"})
    EXPECT_TRUE(check_free(project, free, "--out").ok()) << free;
}

TEST_F(Care, HeldOutFramesCannotBeLeftOut) {
  const auto capture = read_capture(folder_ / "capture.json");
  EXPECT_TRUE(check_left_out(*capture, {}).ok());
  EXPECT_TRUE(check_left_out(*capture, {0, 8}).ok());
  const auto held_out = check_left_out(*capture, {8, 9});
  ASSERT_FALSE(held_out.ok());
  EXPECT_NE(held_out.error().what.find("Frame 9"), std::string::npos);
  EXPECT_FALSE(check_left_out(*capture, {10}).ok());
}

TEST_F(Care, AHeldOutFrameCannotBeTheRestingFace) {
  const auto capture = read_capture(folder_ / "capture.json");
  EXPECT_TRUE(check_rest_frames(*capture, {}).ok());
  EXPECT_TRUE(check_rest_frames(*capture, {0, 8}).ok());
  const auto held_out = check_rest_frames(*capture, {9});
  ASSERT_FALSE(held_out.ok());
  EXPECT_NE(held_out.error().fix.find("face rests"), std::string::npos) << held_out.error().fix;
  EXPECT_FALSE(check_rest_frames(*capture, {10}).ok());
}

TEST_F(Care, LeftOutFramesDoNotTrainAndHeldOutOnesGoOnMeasuring) {
  const auto capture = read_capture(folder_ / "capture.json");
  const Capture trained = without_left_out(*capture, {2, 9});
  int used = 0;
  for (const CaptureFrame& frame : trained.frames) used += frame.used;
  EXPECT_EQ(used, 8);
  EXPECT_FALSE(trained.frames[2].used);
  EXPECT_TRUE(trained.frames[9].held_out);
  EXPECT_TRUE(trained.frames[9].refused.empty());
}

TEST_F(Care, ResultsOfOtherInputsAreOldAndAbsentOnesAreNot) {
  auto project = open_project(folder_);
  for (StageRecord& record : project->stages) record.state = StageState::done;
  ASSERT_TRUE(fs::exists(folder_ / "avatar.bin"));
  const Freshness before = read_freshness(*project);
  for (const Stage stage : kStages) {
    EXPECT_FALSE(before.current[std::size_t(stage)]) << stage_name(stage);  // no hash is right
    EXPECT_TRUE(before.stale[std::size_t(stage)]) << stage_name(stage);
  }
  fs::remove(folder_ / "avatar.bin");
  EXPECT_FALSE(read_freshness(*project).stale[std::size_t(Stage::train)]) << "what is not there is not old";
}

TEST_F(Care, LeftOutFramesAreRememberedInOrder) {
  auto project = open_project(folder_);
  project->options.train.left_out = {7, 3};
  ASSERT_TRUE(save_project(*project).ok());
  EXPECT_EQ(open_project(folder_)->options.train.left_out, (std::vector<int>{3, 7}));
}

}  // namespace
}  // namespace likeness
