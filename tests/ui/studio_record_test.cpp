// A clip recorded in a real window, by clicks: from the start screen to the project that is made of it, with
// stand-ins for the webcams.
#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/video/decode.h"
#include "core/video/encode.h"
#include "tests/ui/stand_in_camera.h"
#include "tests/ui/studio_window.h"
#include "ui/run_window.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;
using test::TestWindow;

class StudioRecord : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_record_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    options_.settings = folder_ / "studio.json";
    options_.projects = folder_ / "projects";
    options_.recording.longest_s = 3600;  // longer than the slowest machine draws these frames
    options_.webcams = test::stand_in_webcams(cameras_);
    studio_ = std::make_unique<Studio>(options_, [] {});
    TestWindow& test = TestWindow::get();
    loop_ = std::make_unique<WindowLoop>(*test.window, *studio_, *test.shell);
    frame();
  }
  void TearDown() override {
    loop_.reset();
    studio_.reset();
    TestWindow::get().window->inject(std::nullopt);
    fs::remove_all(folder_);
  }

  void frame() { going_ = loop_->frame(); }
  void click(const std::string& widget) {
    frame();
    frame();
    test::click(widget, [this] { frame(); });
  }
  void press(int key) {
    InjectedInput input;
    input.key = key, input.ctrl = true;
    TestWindow::get().window->inject(input);
    frame();
    TestWindow::get().window->inject(InjectedInput{});
    frame();
  }
  bool until(const std::function<bool(const Snapshot&)>& so) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < end) {
      frame();
      if (so(studio_->snapshot())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }
  bool until_camera(RecorderState state) {
    return until([=](const Snapshot& s) { return s.recorder && s.recorder->state == state; });
  }
  // The camera is on, and something of a recording is there.
  void film() {
    ASSERT_TRUE(until_camera(RecorderState::watching));
    click("Start recording");
    ASSERT_TRUE(until([](const Snapshot& s) { return s.recorder && s.recorder->recorded_s > 0.5; }));
  }
  std::vector<fs::path> clips() const {
    std::vector<fs::path> found;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(options_.projects, ignored))
      if (!entry.is_directory()) found.push_back(entry.path());
    return found;
  }

  fs::path folder_;
  std::shared_ptr<test::Cameras> cameras_ = std::make_shared<test::Cameras>();
  StudioOptions options_;
  std::unique_ptr<Studio> studio_;
  std::unique_ptr<WindowLoop> loop_;
  bool going_ = true;
};

TEST_F(StudioRecord, FromTheStartScreenToTheProjectOfTheClip) {
  click("Record a clip");
  ASSERT_TRUE(until([](const Snapshot& s) { return s.recorder && s.recorder->picture; }));
  frame();
  EXPECT_TRUE(noted_widgets().contains("mirror"));
  EXPECT_FALSE(noted_widgets().contains("recording mark"));
  test::keep_shot("record_watching");
  // As in a mirror: what is on the camera's left is on the right.
  const Image8 screen = TestWindow::get().window->read_pixels();
  const Rectangle mirror = noted_widgets().at("mirror");
  const int y = int(mirror.low.y + 0.9f * (mirror.high.y - mirror.low.y));
  const std::uint8_t* left = screen.at(int(mirror.low.x + 0.1f * (mirror.high.x - mirror.low.x)), y);
  EXPECT_GT(left[2], left[0] + 100);

  film();
  frame();
  EXPECT_TRUE(noted_widgets().contains("recording mark"));
  EXPECT_TRUE(noted_widgets().contains("cue"));
  EXPECT_TRUE(studio_->is_working());
  test::keep_shot("record_recording");
  click("Stop recording");
  ASSERT_TRUE(until([](const Snapshot& s) { return s.project.contents && s.project.clip_picture.image; }));
  const Snapshot now = studio_->snapshot();
  EXPECT_FALSE(now.recorder.has_value());
  EXPECT_FALSE(now.error.has_value());
  EXPECT_EQ(now.shown, Step::film);
  EXPECT_EQ(now.project.contents->project.consent, Consent::not_asked);
  ASSERT_EQ(clips().size(), 1u);
  EXPECT_EQ(now.project.contents->project.options.shared.video, clips()[0]);
  EXPECT_EQ(now.settings.recent.size(), 1u);
  EXPECT_EQ(cameras_->in_use, 0);
  frame();
  test::keep_shot("record_opened");
  click("It is me");
  ASSERT_TRUE(until([](const Snapshot& s) { return s.project.contents->project.consent == Consent::own; }));

  // From an open project the same page, and back to it.
  press('N');  // with Shift it records: this one browses
  EXPECT_FALSE(studio_->snapshot().recorder.has_value());
  click("Cancel");
  click("menu File");
  click("item Record a clip...");
  ASSERT_TRUE(until_camera(RecorderState::watching));
  EXPECT_FALSE(noted_widgets().contains("step Film"));
  EXPECT_FALSE(is_enabled(Command::make_avatar, studio_->snapshot().situation));
  click("Back without a clip");
  frame();
  EXPECT_TRUE(noted_widgets().contains("step Film"));
  EXPECT_TRUE(studio_->snapshot().project.contents != nullptr);
  EXPECT_EQ(clips().size(), 1u);
}

TEST_F(StudioRecord, WithoutAWebcamItSaysWhatToDo) {
  cameras_->plug({});
  click("Record a clip");
  ASSERT_TRUE(until_camera(RecorderState::failed));
  frame();
  EXPECT_TRUE(noted_widgets().contains("webcam error"));
  EXPECT_FALSE(noted_widgets().contains("Start recording"));
  EXPECT_TRUE(noted_widgets().contains("Open a clip..."));
  EXPECT_FALSE(studio_->snapshot().recorder->error->fix.empty());
  test::keep_shot("record_no_webcam");
  cameras_->plug({{"/dev/video0", "Built-in camera"}});
  click("Try again");
  ASSERT_TRUE(until_camera(RecorderState::watching));
  click("Back without a clip");
  EXPECT_FALSE(studio_->snapshot().recorder.has_value());
  frame();
  EXPECT_TRUE(noted_widgets().contains("Try the demo"));
  EXPECT_TRUE(clips().empty());
}

TEST_F(StudioRecord, ACameraThatBreaksLeavesItsClipAndSaysSo) {
  click("Record a clip");
  film();
  cameras_->broken = true;
  ASSERT_TRUE(until([](const Snapshot& s) { return s.project.contents != nullptr; }));
  const Snapshot now = studio_->snapshot();
  ASSERT_EQ(clips().size(), 1u);
  EXPECT_EQ(now.project.contents->project.options.shared.video, clips()[0]);
  ASSERT_TRUE(now.error.has_value());
  EXPECT_NE(now.error->what.find("cut short"), std::string::npos) << now.error->what;
  EXPECT_NE(now.error->fix.find("is kept"), std::string::npos) << now.error->fix;
  frame();
  test::keep_shot("record_broke_off");
}

TEST_F(StudioRecord, TheEndOfTheProgramAsksAndKeepsTheClip) {
  click("Record a clip");
  film();
  press('Q');
  EXPECT_TRUE(going_);
  for (int i = 0; i < 4; ++i) frame();
  test::keep_shot("record_closing");
  click("Go on recording");
  EXPECT_TRUE(is_recording(*studio_->snapshot().recorder));
  press('Q');
  click("Keep and stop");
  ASSERT_TRUE(until([this](const Snapshot&) { return !going_; }));
  loop_.reset();
  studio_.reset();
  ASSERT_EQ(clips().size(), 1u);
  EXPECT_TRUE(probe_video(clips()[0]).ok());
}

TEST_F(StudioRecord, WhatIsDroppedWaitsForTheEndOfTheRecording) {
  click("Record a clip");
  film();
  TestWindow::get().window->drop({folder_ / "other.mp4"});
  ASSERT_TRUE(until([](const Snapshot& s) { return s.error.has_value(); }));
  EXPECT_NE(studio_->snapshot().error->what.find("is being recorded"), std::string::npos);
  EXPECT_TRUE(is_recording(*studio_->snapshot().recorder));
  EXPECT_FALSE(is_enabled(Command::open_clip, studio_->snapshot().situation));
  EXPECT_FALSE(is_enabled(Command::leave_recorder, studio_->snapshot().situation));
  click("Dismiss");
  click("Discard the recording");
  ASSERT_TRUE(until_camera(RecorderState::watching));
  EXPECT_TRUE(clips().empty());
  // Nothing is being recorded any more: what is dropped now is opened.
  ASSERT_TRUE(fs::create_directories(options_.projects) || fs::exists(options_.projects));
  auto writer = VideoWriter::create(folder_ / "other.mp4", 64, 48);
  ASSERT_TRUE(writer.ok());
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer->add(Image8(64, 48, 3, std::uint8_t(40 * i))).ok());
  ASSERT_TRUE(writer->finish().ok());
  TestWindow::get().window->drop({folder_ / "other.mp4"});
  ASSERT_TRUE(until([](const Snapshot& s) { return s.project.contents != nullptr; }));
  EXPECT_FALSE(studio_->snapshot().recorder.has_value());
  EXPECT_EQ(studio_->snapshot().project.contents->project.options.shared.video, folder_ / "other.mp4");
}

TEST_F(StudioRecord, OneOfSeveralWebcamsIsChosen) {
  cameras_->plug({{"/dev/video0", "Built-in camera"}, {"/dev/video2", "Camera on a cable"}});
  click("Record a clip");
  ASSERT_TRUE(until_camera(RecorderState::watching));
  EXPECT_EQ(cameras_->were_opened(), std::vector<std::string>{"/dev/video0"});
  click("webcams");
  click("webcam /dev/video2");
  ASSERT_TRUE(until([this](const Snapshot& s) {
    return s.recorder->state == RecorderState::watching && cameras_->were_opened().back() == "/dev/video2";
  }));
  frame();
  test::keep_shot("record_two_webcams");
}

TEST_F(StudioRecord, IsDrawnAtEveryScaleInLightAndDark) {
  cameras_->plug({{"/dev/video0", "Built-in camera"}, {"/dev/video2", "Camera on a cable"}});
  click("Record a clip");
  ASSERT_TRUE(until_camera(RecorderState::watching));
  Snapshot s = studio_->snapshot();
  const auto settled = [&] {
    TestWindow::get().window->inject(InjectedInput{});
    for (int i = 0; i < 3; ++i) test::draw_frame(s);
  };
  const auto inside = [](const char* widget) {
    const Rectangle& r = noted_widgets().at(widget);
    return r.low.x >= 0 && r.high.x <= 1280 && r.low.y >= 0 && r.high.y <= 800;
  };
  for (const bool dark : {true, false})
    for (const int scale : {100, 150, 200}) {
      s.settings.dark = dark, s.settings.scale_percent = scale;
      const std::string look = std::to_string(scale) + (dark ? "_dark" : "_light");
      s.recorder->state = RecorderState::watching;
      s.situation = {.recorder = true, .camera_ready = true};
      settled();
      test::keep_shot("record_page_" + look);
      for (const char* widget : {"mirror", "webcams", "Start recording", "Back without a clip"})
        EXPECT_TRUE(inside(widget)) << widget << ' ' << look;
      EXPECT_GT(noted_widgets().at("webcams").low.y, noted_widgets().at("mirror").high.y) << look;
      s.recorder->state = RecorderState::recording;
      s.situation = {.recorder = true, .recording = true, .can_stop_recording = true};
      for (const double recorded_s : {5.0, 170.0}) {
        s.recorder->recorded_s = recorded_s;
        settled();
        test::keep_shot("record_page_" + std::to_string(int(recorded_s)) + "_" + look);
        for (const char* widget : {"mirror", "Stop recording", "Discard the recording", "recording mark"})
          EXPECT_TRUE(inside(widget)) << widget << ' ' << look;
        EXPECT_EQ(noted_widgets().contains("cue"), recorded_s < 60) << look;
      }
    }
}

}  // namespace
}  // namespace likeness::ui
