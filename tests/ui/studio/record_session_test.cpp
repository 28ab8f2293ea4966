// Claims about the studio's recorder, without a window or a project, with a stand-in for the webcam.
#include "ui/studio/record_session.h"

#include <gtest/gtest.h>

#include "tests/ui/stand_in_camera.h"
#include "tests/ui/studio/session_home.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;

class RecordSessionTest : public testing::Test {
 protected:
  RecordSessionTest() { home_.options.webcams = test::stand_in_webcams(cameras_); }

  bool until(const std::function<bool()>& so) {
    return home_.until(
        [this] {
          if (const auto clip = session_.tick()) handed_over_.push_back(*clip);
        },
        so);
  }
  void record_a_little() {
    session_.start(nullptr);
    ASSERT_TRUE(until([this] { return session_.view()->state == RecorderState::watching; }));
    session_.record();
    ASSERT_TRUE(until([this] { return session_.view()->recorded_s > 0.3; }));
  }

  std::shared_ptr<test::Cameras> cameras_ = std::make_shared<test::Cameras>();
  test::SessionHome home_;
  RecordSession session_{home_.context};
  std::vector<fs::path> handed_over_;
};

TEST_F(RecordSessionTest, AClipIsHandedOverOnce) {
  record_a_little();
  EXPECT_TRUE(session_.is_recording());
  EXPECT_TRUE(session_.goes_on());
  session_.finish();
  ASSERT_TRUE(until([this] { return !handed_over_.empty(); }));
  EXPECT_FALSE(session_.is_on());
  EXPECT_FALSE(session_.view().has_value());
  EXPECT_TRUE(fs::exists(handed_over_[0]));
  EXPECT_EQ(handed_over_[0].parent_path(), home_.options.projects);
  EXPECT_FALSE(session_.tick().has_value());
  EXPECT_FALSE(home_.notices.error.has_value());
}

TEST_F(RecordSessionTest, WhatIsRecordedWhenTheProgramEndsIsKeptAndNotOpened) {
  record_a_little();
  session_.stop();
  EXPECT_FALSE(session_.goes_on());
  ASSERT_TRUE(until([this] { return !session_.is_on(); }));
  EXPECT_TRUE(handed_over_.empty());
  EXPECT_EQ(home_.notices.message.rfind("Recorded: ", 0), 0u) << home_.notices.message;
  EXPECT_TRUE(fs::exists(home_.notices.message.substr(10)));
}

TEST_F(RecordSessionTest, TheCameraIsLeftOnlyWhileNothingIsRecorded) {
  record_a_little();
  session_.leave();
  EXPECT_TRUE(session_.is_on());
  session_.discard();
  ASSERT_TRUE(until([this] { return session_.view()->state == RecorderState::watching; }));
  session_.leave();
  EXPECT_FALSE(session_.is_on());
  EXPECT_TRUE(handed_over_.empty());
}

TEST_F(RecordSessionTest, AnotherWebcamIsOpenedWhereItIsAskedFor) {
  cameras_->plug({{"/dev/video0", "Built-in camera"}, {"/dev/video2", "On the shelf"}});
  session_.apply({.webcam = "/dev/video2"});  // no camera is on: nothing is opened
  EXPECT_TRUE(cameras_->were_opened().empty());
  session_.start(nullptr);
  ASSERT_TRUE(until([this] { return session_.view()->state == RecorderState::watching; }));
  session_.apply({.webcam = "/dev/video2"});
  ASSERT_TRUE(until([this] { return cameras_->were_opened().size() == 2; }));
  EXPECT_EQ(cameras_->were_opened().back(), "/dev/video2");
}

}  // namespace
}  // namespace likeness::ui
