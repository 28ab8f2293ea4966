// Claims about the studio's masks, without a window: what is painted reaches the disk, and what is read
// meanwhile does not undo it.
#include "ui/studio/mask_session.h"

#include <gtest/gtest.h>

#include "core/project/corrections.h"
#include "tests/ui/studio/session_home.h"

namespace likeness::ui {
namespace {

Stroke line(double x) { return {StrokeMark::person, 4, {{x, 10}}}; }

class MaskSessionTest : public testing::Test {
 protected:
  // Frames 1 to 3 of the tiny project have masks, as far as the window can know; 3 does not train.
  void SetUp() override {
    home_.open_project();
    auto contents = std::make_shared<ProjectContents>(*home_.open.contents);
    Capture capture;
    for (const int frame : {1, 2, 3}) {
      CaptureFrame& made = capture.frames.emplace_back();
      made.frame = frame, made.used = frame != 3, made.held_out = frame == 3;
    }
    contents->capture = std::make_shared<const Capture>(capture);
    CameraSet cameras;
    cameras.cameras.emplace_back().frame = -1;
    contents->cameras = std::make_shared<const CameraSet>(cameras);
    contents->track = std::make_shared<const Track>();
    home_.open.contents = contents;
    home_.shown.step = Step::cameras;
    session_.reading_begins();
    session_.was_read(true);
    session_.apply({.shown = true, .frame = 1});
  }
  bool until(const std::function<bool()>& so) {
    return home_.until([this] { session_.tick(); }, so);
  }
  Strokes on_disk(int frame) const {
    const auto read = read_strokes(strokes_path(home_.open.contents->project, frame));
    return read ? *read : Strokes{};
  }

  test::SessionHome home_;
  int readings_ = 0;
  MaskSession session_{home_.context, [this] { ++readings_; }};
};

TEST_F(MaskSessionTest, AStrokeIsWrittenAtOnceAndTheProjectReadAgainOnceItSettles) {
  EXPECT_TRUE(session_.are_shown());
  session_.apply({.stroke = line(5)});
  EXPECT_TRUE(session_.is_settling());
  EXPECT_TRUE(session_.view().unmade) << "the masks were made before the stroke";
  ASSERT_TRUE(until([this] { return on_disk(1) == Strokes{line(5)}; }));
  ASSERT_TRUE(until([this] { return readings_ == 1; }));
  EXPECT_FALSE(session_.is_settling());
  session_.undo();
  ASSERT_TRUE(until([this] { return on_disk(1).empty(); }));
}

TEST_F(MaskSessionTest, WhatIsPaintedDuringAReadingStays) {
  session_.reading_begins();  // of a folder without strokes
  session_.apply({.stroke = line(5)});
  session_.was_read(false);
  EXPECT_EQ(*session_.view().strokes, Strokes{line(5)});
  ASSERT_TRUE(until([this] { return !on_disk(1).empty(); }));
  session_.reading_begins();
  session_.was_read(false);
  EXPECT_TRUE(session_.view().strokes->empty()) << "the disk counts where nothing was painted meanwhile";
}

TEST_F(MaskSessionTest, NothingIsPaintedWhileTheStagesAreAtWork) {
  home_.open.pipeline.job.state = JobState::running;
  session_.apply({.stroke = line(5)});
  EXPECT_TRUE(session_.view().strokes->empty());
  session_.undo();
  session_.step(1);  // looking is possible
  EXPECT_EQ(session_.view().frame, 2);
  EXPECT_FALSE(session_.view().can_undo);
}

TEST_F(MaskSessionTest, AnAttributeIsPaintedWhereAFrameTrains) {
  session_.apply({.attributes = {.on = true, .name = "puff"}});
  session_.apply({.stroke = line(5)});
  EXPECT_EQ(*session_.view().strokes, Strokes{line(5)});
  EXPECT_TRUE(on_disk(1).empty()) << "the masks themselves stay";
  session_.apply({.frame = 3});
  session_.apply({.stroke = line(6)});
  ASSERT_TRUE(home_.notices.error.has_value());
  EXPECT_TRUE(session_.view().strokes->empty());
}

TEST_F(MaskSessionTest, StrokesAreWrittenBeforeTheirProjectCloses) {
  session_.apply({.stroke = line(5)});
  session_.close();
  home_.open.contents.reset();
  home_.open.folder.clear();
  EXPECT_FALSE(session_.are_shown());
  EXPECT_TRUE(session_.view().frames->empty());
  const Project project{home_.project.folder(), {}, {}};
  ASSERT_TRUE(until([&] { return read_strokes(strokes_path(project, 1)).ok(); }));
  EXPECT_EQ(readings_, 0);
}

}  // namespace
}  // namespace likeness::ui
