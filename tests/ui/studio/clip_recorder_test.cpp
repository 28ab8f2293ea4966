// Claims about recording a clip while it is watched, with stand-ins for the webcams.
#include "ui/studio/clip_recorder.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/video/decode.h"
#include "tests/core/video/video_test_clip.h"
#include "tests/ui/stand_in_camera.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;

class Recorder : public InFolder {
 protected:
  void SetUp() override {
    InFolder::SetUp();
    start();
  }
  void TearDown() override {
    recorder_.reset();
    InFolder::TearDown();
  }
  void start() {
    recorder_ = std::make_unique<ClipRecorder>(test::stand_in_webcams(cameras_),
                                               RecorderOptions{.folder = folder_}, [this] { ++woken_; });
  }
  // False where it does not come to be so in a long time.
  bool until(const std::function<bool(const RecorderStatus&)>& so) {
    for (int i = 0; i < 12000; ++i) {
      if (so(recorder_->status())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }
  bool until(RecorderState state) {
    return until([=](const RecorderStatus& s) { return s.state == state; });
  }
  // Something of a recording.
  void film() {
    ASSERT_TRUE(until(RecorderState::watching));
    recorder_->record();
    ASSERT_TRUE(until([](const RecorderStatus& s) { return s.recorded_s > 0.3; }));
  }

  std::shared_ptr<test::Cameras> cameras_ = std::make_shared<test::Cameras>();
  std::atomic<int> woken_{0};
  std::unique_ptr<ClipRecorder> recorder_;
};

TEST_F(Recorder, WatchingKeepsNothing) {
  ASSERT_TRUE(until([](const RecorderStatus& s) { return s.state == RecorderState::watching && s.picture; }));
  EXPECT_GT(woken_, 0);
  EXPECT_EQ(recorder_->status().picture->width, 96);
  EXPECT_EQ(recorder_->status().webcams.size(), 1u);
  recorder_->finish();  // nothing is being recorded
  recorder_->discard();
  EXPECT_EQ(recorder_->status().state, RecorderState::watching);
  recorder_.reset();
  EXPECT_EQ(files(), 0u);
  EXPECT_EQ(cameras_->in_use, 0);
}

TEST_F(Recorder, WhatIsRecordedIsKeptAsAClip) {
  film();
  recorder_->finish();
  ASSERT_TRUE(until(RecorderState::kept));
  const RecorderStatus status = recorder_->status();
  ASSERT_TRUE(status.recording.has_value());
  EXPECT_FALSE(status.recording->interruption.has_value());
  EXPECT_EQ(status.clip.parent_path(), folder_);
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(cameras_->in_use, 0) << "the camera is still on";
  const auto info = probe_video(status.clip);
  ASSERT_TRUE(info.ok()) << info.error().what;
  EXPECT_NEAR(info->duration_s, status.recording->seconds, 0.1);
  // As the camera saw it, not as the mirror showed it.
  auto reader = VideoReader::open(status.clip);
  ASSERT_TRUE(reader.ok());
  const auto first = reader->next();
  ASSERT_TRUE(first.ok() && *first);
  EXPECT_GT((*first)->rgb.at(10, 60)[0], 150);
  EXPECT_GT((*first)->rgb.at(86, 60)[2], 150);
}

TEST_F(Recorder, ItEndsByItselfAfterTheLongestTime) {
  recorder_ = std::make_unique<ClipRecorder>(
      test::stand_in_webcams(cameras_),
      RecorderOptions{.folder = folder_, .record = {.frames_per_second = 30, .longest_s = 0.5}}, [] {});
  ASSERT_TRUE(until(RecorderState::watching));
  EXPECT_EQ(recorder_->status().longest_s, 0.5);
  recorder_->record();
  ASSERT_TRUE(until(RecorderState::kept));
  EXPECT_NEAR(recorder_->status().recording->seconds, 0.5, 0.05);
}

TEST_F(Recorder, ACameraThatBreaksLeavesWhatItGave) {
  film();
  cameras_->broken = true;
  ASSERT_TRUE(until(RecorderState::kept));
  const RecorderStatus status = recorder_->status();
  ASSERT_TRUE(status.recording->interruption.has_value());
  EXPECT_FALSE(status.recording->interruption->fix.empty());
  EXPECT_TRUE(probe_video(status.clip).ok());
}

TEST_F(Recorder, ACameraThatFailsBeforeRecordingIsReportedAndTriedAgain) {
  ASSERT_TRUE(until(RecorderState::watching));
  cameras_->broken = true;
  ASSERT_TRUE(until(RecorderState::failed));
  RecorderStatus status = recorder_->status();
  ASSERT_TRUE(status.error.has_value());
  EXPECT_FALSE(status.error->fix.empty());
  EXPECT_EQ(status.picture, nullptr) << "an old picture looks like a live one";
  recorder_->record();
  EXPECT_EQ(recorder_->status().state, RecorderState::failed);
  cameras_->broken = false;
  recorder_->choose("");
  film();
  EXPECT_FALSE(recorder_->status().error.has_value());
}

TEST_F(Recorder, ACameraThatEndsIsReportedWithARemedy) {
  ASSERT_TRUE(until(RecorderState::watching));
  cameras_->ended = true;
  ASSERT_TRUE(until(RecorderState::failed));
  EXPECT_FALSE(recorder_->status().error->fix.empty());
}

TEST_F(Recorder, WithoutAWebcamItSaysSoUntilThereIsOne) {
  cameras_->plug({});
  start();
  ASSERT_TRUE(until(RecorderState::failed));
  EXPECT_EQ(recorder_->status().error->code, ErrorCode::not_found);
  cameras_->plug({{"/dev/video2", "Plugged in"}});
  recorder_->choose("");
  ASSERT_TRUE(until(RecorderState::watching));
  EXPECT_EQ(recorder_->status().webcams.at(0).name, "Plugged in");
}

TEST_F(Recorder, AnotherCameraTakesItsPlaceButNotWhileItRecords) {
  cameras_->plug({{"/dev/video0", "a"}, {"/dev/video4", "b"}});
  start();
  ASSERT_TRUE(until(RecorderState::watching));
  recorder_->choose("/dev/video4");
  ASSERT_TRUE(until([&](const RecorderStatus& s) {
    return s.state == RecorderState::watching && cameras_->were_opened().back() == "/dev/video4";
  }));
  EXPECT_EQ(cameras_->in_use, 1);
  film();
  const std::size_t opened = cameras_->were_opened().size();
  recorder_->choose("/dev/video0");
  EXPECT_EQ(recorder_->status().state, RecorderState::recording);
  recorder_->finish();
  ASSERT_TRUE(until(RecorderState::kept));
  EXPECT_EQ(cameras_->were_opened().size(), opened);
}

TEST_F(Recorder, ADiscardedRecordingLeavesNothingAndTheCameraGoesOn) {
  film();
  recorder_->discard();
  ASSERT_TRUE(until(RecorderState::watching));
  EXPECT_EQ(files(), 0u);
  film();
  recorder_->finish();
  ASSERT_TRUE(until(RecorderState::kept));
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(cameras_->were_opened().size(), 1u);
}

TEST_F(Recorder, ARecordingThatHasJustEndedCanStillBeDiscarded) {
  film();
  cameras_->slow = true;
  cameras_->broken = true;
  ASSERT_TRUE(until([&](const RecorderStatus&) { return cameras_->leaving.load(); }));
  recorder_->discard();
  cameras_->broken = false;
  cameras_->slow = false;
  ASSERT_TRUE(until(RecorderState::watching));
  EXPECT_EQ(files(), 0u);
  EXPECT_FALSE(recorder_->status().recording.has_value());
}

TEST_F(Recorder, AStopBeforeTheFirstPictureIsNoFailure) {
  ASSERT_TRUE(until(RecorderState::watching));
  cameras_->held = true;
  ASSERT_TRUE(until([&](const RecorderStatus&) { return cameras_->waiting.load(); }));
  recorder_->record();
  EXPECT_TRUE(is_recording(recorder_->status()));
  recorder_->finish();
  cameras_->held = false;
  ASSERT_TRUE(until(RecorderState::watching));
  EXPECT_EQ(files(), 0u);
}

TEST_F(Recorder, TheEndOfTheProgramKeepsWhatIsRecorded) {
  film();
  const fs::path clip = recorder_->status().clip;
  recorder_.reset();
  EXPECT_TRUE(probe_video(clip).ok());
  EXPECT_EQ(files(), 1u);
}

TEST_F(Recorder, AFolderThatCannotBeWrittenIsReportedWithARemedy) {
  const fs::path wall = folder_ / "file";
  std::ofstream(wall) << "in the way";
  recorder_ = std::make_unique<ClipRecorder>(test::stand_in_webcams(cameras_),
                                             RecorderOptions{.folder = wall / "clips"}, [] {});
  ASSERT_TRUE(until(RecorderState::watching));
  recorder_->record();
  ASSERT_TRUE(until(RecorderState::failed));
  EXPECT_FALSE(recorder_->status().error->what.empty());
  EXPECT_FALSE(recorder_->status().error->fix.empty());
}

TEST_F(Recorder, AClipsNameIsNeitherAFilesNorAProjects) {
  const std::time_t now = 1'700'000'000;
  const fs::path first = clip_path(folder_, now);
  EXPECT_EQ(first.parent_path(), folder_);
  EXPECT_EQ(first.extension(), ".mp4");
  EXPECT_EQ(clip_path(folder_, now), first) << "nothing is made yet";
  EXPECT_NE(clip_path(folder_, now + 1), first);
  std::ofstream(first) << "mine";
  const fs::path second = clip_path(folder_, now);
  EXPECT_NE(second, first);
  // A project whose clip is gone keeps its name.
  fs::create_directory(fs::path(second).replace_extension(".likeness"));
  const fs::path third = clip_path(folder_, now);
  EXPECT_NE(third, first);
  EXPECT_NE(third, second);
}

}  // namespace
}  // namespace likeness::ui
