// Directing in a real window with the studio behind it, on an avatar made up in code: keys by mouse and by
// keyboard, undo, playing, and what is kept in the project.
#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/files.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/scene/track.h"
#include "core/video/webcam.h"
#include "tests/core/drive/demo_clip.h"
#include "tests/core/export/tiny_project.h"
#include "tests/ui/stand_in_camera.h"
#include "tests/ui/studio_window.h"
#include "ui/run_window.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;
using likeness::test::filmed_avatar;
using test::TestWindow;

class StudioDirect : public testing::Test {
 protected:
  void SetUp() override {
    Avatar avatar = filmed_avatar();
    avatar.size = 64;
    avatar.intrinsics = {64, 64, 110, 110, 32, 32, 0, 0, 0, 0};
    avatar.plate = Image8(64, 64, 3, 77);
    ASSERT_TRUE(write_avatar(project_.folder() / "avatar.bin", avatar).ok());
    auto project = open_project(project_.folder());
    ASSERT_TRUE(project.ok());
    project->consent = Consent::no_real_person;
    ASSERT_TRUE(save_project(*project).ok());
    start();
  }
  void TearDown() override {
    loop_.reset();
    studio_.reset();
    TestWindow::get().window->inject(std::nullopt);
  }

  void start() {
    loop_.reset();
    studio_.reset();  // what is unsaved is written before another reads it
    StudioOptions options;
    options.settings = project_.root / "studio.json";
    options.projects = project_.root;
    options.webcams = test::stand_in_webcams(cameras_);
    studio_ = std::make_unique<Studio>(options, [] {});
    TestWindow& test = TestWindow::get();
    loop_ = std::make_unique<WindowLoop>(*test.window, *studio_, *test.shell);
    test.shell->views().timeline = {};
    Requests open;
    open.open = project_.folder();
    studio_->apply(open);
    ASSERT_TRUE(until(30, [](const Snapshot& s) { return s.direct.picture && s.direct.picture->last; }));
    frame();
  }
  void frame() { loop_->frame(); }
  bool until(double seconds, const std::function<bool(const Snapshot&)>& so) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
      frame();
      if (so(studio_->snapshot())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
    }
    return false;
  }
  void click(const std::string& widget) {
    frame();
    test::click(widget, [this] { frame(); });
  }
  void press(int key, bool ctrl = false, bool shift = false) {
    InjectedInput input;
    input.key = key, input.ctrl = ctrl, input.shift = shift;
    TestWindow::get().window->inject(input);
    frame();
    TestWindow::get().window->inject(InjectedInput{});
    frame();
  }
  // Where a time lies in a row of the timeline.
  static ImVec2 place(const std::string& row, double time_s, double duration_s) {
    const Rectangle& r = noted_widgets().at(row);
    return {r.low.x + float(time_s / (1.02 * duration_s)) * (r.high.x - r.low.x),
            0.5f * (r.low.y + r.high.y)};
  }
  // Presses at one place, moves to another, and lets go.
  void drag(ImVec2 from, ImVec2 to, bool twice = false) {
    Window& window = *TestWindow::get().window;
    InjectedInput input;
    const auto at = [&](ImVec2 p, bool down) {
      input.mouse_x = p.x, input.mouse_y = p.y;
      input.down[0] = down;
      window.inject(input);
      frame();
    };
    at(from, false);
    for (int press = 0; press < (twice ? 2 : 1); ++press) {
      at(from, true);
      if (press == 0 && twice) at(from, false);
    }
    for (int i = 1; i <= 4; ++i)
      at({from.x + (to.x - from.x) * float(i) / 4, from.y + (to.y - from.y) * float(i) / 4}, true);
    at(to, false);
    at({1, 1}, false);
  }
  const Performance& performance() {
    kept_ = studio_->snapshot().direct.directing.performance;
    return *kept_;
  }
  std::vector<Key> keys(const std::string& channel) {
    const auto found = performance().channels.find(channel);
    return found == performance().channels.end() ? std::vector<Key>{} : found->second;
  }
  double playhead() { return studio_->snapshot().direct.directing.playhead_s; }

  likeness::test::TinyProject project_;
  std::shared_ptr<test::Cameras> cameras_ = std::make_shared<test::Cameras>();
  std::unique_ptr<Studio> studio_;
  std::unique_ptr<WindowLoop> loop_;
  std::shared_ptr<const Performance> kept_;
};

TEST_F(StudioDirect, KeysAreRecordedMovedAndDeletedByTheMouse) {
  click("Record keys");
  drag(place("ruler", 0.5, 4), place("ruler", 2, 4));  // scrubs
  EXPECT_NEAR(playhead(), 2, 0.05);
  const double at = playhead();
  test::drag("##head yaw", 40, 0, 0, [this] { frame(); });
  ASSERT_EQ(keys("head yaw").size(), 2u);  // rest at the start, and here
  EXPECT_EQ(keys("head yaw")[0], (Key{0, 0}));
  EXPECT_NEAR(keys("head yaw")[1].time_s, at, 1e-6);
  test::keep_shot("timeline_two_keys");

  frame();
  drag(place("row head yaw", at, 4), place("row head yaw", 3, 4));
  EXPECT_NEAR(keys("head yaw")[1].time_s, 3, 0.08);
  EXPECT_EQ(studio_->snapshot().direct.directing.selected->size(), 1u);
  press('Z', true);
  EXPECT_NEAR(keys("head yaw")[1].time_s, at, 1e-6);
  press('Y', true);
  EXPECT_NEAR(keys("head yaw")[1].time_s, 3, 0.08);

  // A double click on the row makes a key on the way, which the curve already passed.
  const float before = value_at(performance(), "head yaw", 1);
  drag(place("row head yaw", 1, 4), place("row head yaw", 1, 4), true);
  ASSERT_EQ(keys("head yaw").size(), 3u);
  EXPECT_NEAR(keys("head yaw")[1].value, before, 0.3f);
  press(GLFW_KEY_DELETE);
  EXPECT_EQ(keys("head yaw").size(), 2u);
  // A box about everything.
  const Rectangle row = noted_widgets().at("row head yaw");
  drag({row.high.x - 1, row.high.y - 1}, {row.low.x - 10, row.low.y + 1});
  EXPECT_EQ(studio_->snapshot().direct.directing.selected->size(), 2u);
  press(GLFW_KEY_DELETE);
  EXPECT_EQ(performance().channels.size(), 0u);
}

TEST_F(StudioDirect, TheKeyboardReachesEverything) {
  press('R', true, true);  // record
  EXPECT_TRUE(studio_->snapshot().direct.directing.record_keys);
  press(GLFW_KEY_END);
  EXPECT_NEAR(playhead(), 3.96, 1e-6);
  press(GLFW_KEY_LEFT, true);
  EXPECT_NEAR(playhead(), 3.92, 1e-6);
  press('J', true);  // a random walk
  const auto walk = performance();
  EXPECT_GT(walk.channels.size(), 1u);
  EXPECT_EQ(walk.duration_s, 8);
  press('J', true);
  EXPECT_NE(performance(), walk);  // another one
  press('Z', true);
  EXPECT_EQ(performance(), walk);
  press(GLFW_KEY_HOME);
  press(GLFW_KEY_RIGHT, true, true);  // the next key
  EXPECT_GT(playhead(), 0);
  press('D', true);
  const auto chosen = *studio_->snapshot().direct.directing.selected;
  ASSERT_FALSE(chosen.empty());
  press(GLFW_KEY_RIGHT, false, true);
  EXPECT_NEAR(studio_->snapshot().direct.directing.selected->front().time_s, chosen.front().time_s + 0.04,
              1e-6);
  press('C', true);
  press(GLFW_KEY_END);
  const std::size_t before = all_keys(performance()).size();
  press('V', true);
  EXPECT_GT(all_keys(performance()).size(), before);
  press('G', true);
  EXPECT_EQ(find_key(performance(), studio_->snapshot().direct.directing.selected->front())->easing,
            Easing::hold);
  press(GLFW_KEY_DELETE);
  EXPECT_EQ(all_keys(performance()).size(), before);
  press('A', true);
  EXPECT_EQ(studio_->snapshot().direct.directing.selected->size(), before);
  press('C', true, true);  // the pose
  press(GLFW_KEY_HOME);
  press('V', true, true);
  EXPECT_EQ(pose_at(performance(), 0), pose_at(performance(), 7.96));
  press('1', true);  // the face rests
  for (const auto& [channel, value] : pose_at(performance(), 0))
    EXPECT_EQ(part_of(channel), ChannelPart::head) << channel;
}

TEST_F(StudioDirect, PlayingMovesThePlayheadAndThePicture) {
  press('J', true);
  const std::uint64_t moment = studio_->snapshot().direct.moment;
  press(GLFW_KEY_SPACE);
  ASSERT_TRUE(studio_->snapshot().direct.directing.playing);
  EXPECT_LT(studio_->patience_s(), 0.1);  // the window looks again soon
  ASSERT_TRUE(until(20, [&](const Snapshot& s) {
    return s.direct.directing.playhead_s > 0.2 && s.direct.picture &&
           s.direct.picture->origin.moment > moment + 2;
  }));
  test::keep_shot("timeline_playing");
  click("play");
  EXPECT_FALSE(studio_->snapshot().direct.directing.playing);
  // At rest the picture becomes the best one again.
  ASSERT_TRUE(until(20, [](const Snapshot& s) {
    return s.direct.picture->last && s.direct.picture->origin.moment == s.direct.moment;
  }));
}

TEST_F(StudioDirect, WhatIsDirectedIsKeptAndABrokenFileIsPutAside) {
  press('J', true);
  const Performance directed = performance();
  start();
  ASSERT_TRUE(until(10, [&](const Snapshot& s) { return *s.direct.directing.performance == directed; }));
  const fs::path file = project_.folder() / "performance.json";
  loop_.reset();
  studio_.reset();
  ASSERT_TRUE(write_text(file, "{").ok());
  start();
  ASSERT_TRUE(until(10, [](const Snapshot& s) { return s.error.has_value(); }));
  EXPECT_NE(studio_->snapshot().error->fix.find("performance-unread.json"), std::string::npos);
  EXPECT_TRUE(fs::exists(project_.folder() / "performance-unread.json"));
  click("Dismiss");
  press('J', true);
  // It is written by itself soon after.
  ASSERT_TRUE(until(10, [&](const Snapshot&) { return fs::exists(file); }));
  EXPECT_EQ(*read_performance(file), performance());
}

TEST_F(StudioDirect, APerformanceIsSavedUnderANameAndOpenedAgain) {
  press('J', true);
  const Performance walk = performance();
  press('S', true, true);
  frame();
  frame();
  test::keep_shot("timeline_save_as");
  click("Save");
  ASSERT_TRUE(until(5, [](const Snapshot& s) { return !s.message.empty(); }));
  const fs::path file = project_.folder() / "performance-1.json";
  EXPECT_EQ(*read_performance(file), walk);
  click("Dismiss");
  press('J', true);
  EXPECT_NE(performance(), walk);
  press('O', true, true);
  ASSERT_TRUE(
      until(10, [](const Snapshot&) { return noted_widgets().contains("entry performance-1.json"); }));
  click("entry performance-1.json");
  click("Open");
  ASSERT_TRUE(until(5, [&](const Snapshot& s) { return *s.direct.directing.performance == walk; }));
  press('Z', true);  // opening is a step like any other
  EXPECT_NE(performance(), walk);
}

TEST_F(StudioDirect, ViewsThatWereNeverSeenFadeAndTheWindowSaysSo) {
  EXPECT_EQ(studio_->snapshot().direct.picture->origin.doubt,
            0);  // no frame is known: nothing to compare with
  // One frame, seen as the avatar rests.
  const Avatar avatar = filmed_avatar();
  Capture capture;
  capture.width = capture.height = capture.size = 64;
  capture.frames_per_second = 25;
  capture.crop = {0, 0, 64};
  capture.frames = {{.frame = 0, .used = true}};
  CameraSet cameras;
  cameras.cameras = {{.frame = -1, .intrinsics = {64, 64, 110, 110, 32, 32, 0, 0, 0, 0}}};
  Track track;
  track.head_model_name = avatar.head_model_name, track.head_model_hash = avatar.head_model_hash;
  track.person = avatar.person;
  track.neutral = avatar.neutral;
  track.frames.resize(1);
  track.frames[0].pose.world_from_head = avatar.world_from_head;
  track.frames[0].pose.world_from_torso = avatar.world_from_torso;
  track.frames[0].pose.articulation = avatar.neutral;
  const auto project = open_project(project_.folder());
  ASSERT_TRUE(write_capture(capture_path(*project), capture).ok());
  ASSERT_TRUE(write_cameras(cameras_path(*project), cameras).ok());
  ASSERT_TRUE(write_track(track_path(*project), track).ok());
  start();
  const auto told = [] { return noted_widgets().contains("beyond"); };
  ASSERT_FALSE(studio_->snapshot().project.contents->avatar->views.views.empty());
  EXPECT_EQ(studio_->snapshot().direct.picture->origin.doubt, 0);
  EXPECT_FALSE(told());
  Requests turn;
  Performance turned;
  turned.channels["head yaw"] = {{0, 25}};
  turn.direct.edit(turned, "turn");
  studio_->apply(turn);
  ASSERT_TRUE(until(20, [](const Snapshot& s) {
    return s.direct.picture && s.direct.picture->origin.moment == s.direct.moment;
  }));
  EXPECT_GT(studio_->snapshot().direct.picture->origin.doubt, 0.2);
  frame();
  EXPECT_TRUE(told());
  test::keep_shot("direct_never_seen");
}

TEST_F(StudioDirect, TheTimelineIsDrawnAtEveryScaleInBothThemes) {
  click("Record keys");
  press('J', true);
  for (const int scale : {100, 150, 200})
    for (const bool dark : {true, false}) {
      for (int steps = 0; steps < 20 && studio_->snapshot().settings.scale_percent < scale; ++steps)
        press('=', true);
      for (int steps = 0; steps < 20 && studio_->snapshot().settings.scale_percent > scale; ++steps)
        press('-', true);
      ASSERT_EQ(studio_->snapshot().settings.scale_percent, scale) << "no key arrives";
      if (studio_->snapshot().settings.dark != dark) press('L', true);
      for (int i = 0; i < 3; ++i) frame();
      test::keep_shot(std::string("timeline_") + std::to_string(scale) + (dark ? "_dark" : "_light"));
      EXPECT_GT(test::liveliness(TestWindow::get().window->read_pixels(), "timeline"), 5) << scale;
      EXPECT_GT(test::liveliness(TestWindow::get().window->read_pixels(), "play"), 5) << scale;
    }
}

TEST_F(StudioDirect, AVideoDrivesTheAvatarAndTheDriveBecomesKeys) {
  Requests drive;
  drive.direct.drive_video = likeness::test::long_clip();
  studio_->apply(drive);
  frame();
  ASSERT_TRUE(studio_->snapshot().direct.live.on);
  press('E', true, true);
  EXPECT_TRUE(studio_->snapshot().direct.live.status.recording);
  // A gain, while it runs.
  Requests gain;
  gain.direct.gains = std::map<std::string, float>{{"jawOpen", 1.5f}};
  studio_->apply(gain);
  bool followed = false, pictured = false;
  ASSERT_TRUE(until(90, [&](const Snapshot& s) {
    if (s.direct.picture && s.direct.picture->origin.captured && s.direct.live.on &&
        s.direct.live.latency_s > 0 && !pictured) {
      followed = true;
      EXPECT_EQ(s.direct.live.status.source, "long.mp4");
      frame();
      test::keep_shot("drive_live");
      pictured = test::liveliness(TestWindow::get().window->read_pixels(), "driver picture") > 5;
    }
    return !s.direct.live.on || (pictured && s.direct.live.status.recorded_s > 1);
  }));
  EXPECT_TRUE(followed);
  EXPECT_TRUE(pictured);
  Requests enough;
  enough.ask(Command::stop_driving);
  studio_->apply(enough);
  EXPECT_FALSE(studio_->snapshot().direct.live.on);
  ASSERT_TRUE(
      until(20, [&](const Snapshot& s) { return !s.direct.directing.performance->channels.empty(); }));
  EXPECT_GT(keys("head yaw").size(), 2u);
  EXPECT_EQ(studio_->snapshot().direct.directing.undo_name, "record the drive");
  for (int i = 0; i < 3; ++i) frame();
  test::keep_shot("drive_keys");
  press('Z', true);
  EXPECT_TRUE(performance().channels.empty());
}

TEST_F(StudioDirect, ARecordedDriveSurvivesTheEndOfTheProgram) {
  Requests drive;
  drive.direct.drive_video = likeness::test::long_clip();
  studio_->apply(drive);
  frame();
  press('E', true, true);
  const auto recorded = [](const Snapshot& s) { return s.direct.live.status.recorded_s > 0.3; };
  ASSERT_TRUE(until(60, recorded));
  start();  // in the middle of it
  ASSERT_TRUE(until(20, [](const Snapshot& s) { return !s.direct.directing.performance->channels.empty(); }));
  EXPECT_GT(keys("head yaw").size(), 2u);
}

TEST_F(StudioDirect, ADriveEndsWhereAClipIsRecordedAndTheProjectStays) {
  Requests drive;
  drive.direct.drive_video = likeness::test::long_clip();
  studio_->apply(drive);
  ASSERT_TRUE(until(30, [](const Snapshot& s) { return s.direct.live.on; }));
  press('N', true, true);
  ASSERT_TRUE(until(
      60, [](const Snapshot& s) { return s.recorder && s.recorder->state == RecorderState::watching; }));
  EXPECT_FALSE(studio_->snapshot().direct.live.on) << "two of them hold one camera";
  EXPECT_FALSE(noted_widgets().contains("avatar view"));
  press('J', true);  // what is not seen is not changed
  EXPECT_TRUE(performance().channels.empty());
  click("Back without a clip");
  frame();
  EXPECT_TRUE(noted_widgets().contains("avatar view"));
  press('J', true);
  EXPECT_FALSE(performance().channels.empty());
}

TEST_F(StudioDirect, AMissingWebcamIsReportedWithARemedy) {
  if (open_webcam({}, kToDrive)) GTEST_SKIP() << "there is a webcam";
  click("Drive from the webcam");
  ASSERT_TRUE(until(20, [](const Snapshot& s) { return s.error.has_value(); }));
  EXPECT_FALSE(studio_->snapshot().error->fix.empty());
  ASSERT_TRUE(until(5, [](const Snapshot& s) { return !s.direct.live.on; }));
  click("Dismiss");
}

}  // namespace
}  // namespace likeness::ui
