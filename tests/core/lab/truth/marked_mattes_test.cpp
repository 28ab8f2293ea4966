// Claims about measuring mattes by people drawn by hand.
#include "core/lab/truth/marked_mattes.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/base/files.h"
#include "core/image/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// A square head, 100 px wide, on a torso that is wider: the drawing is unsure of 1 px to either side.
PersonOutline drawn_figure(int frame = 0) {
  PersonOutline outline;
  outline.frame = frame;
  outline.person = {
      {{50, 200}, {50, 150}, {100, 150}, {100, 40}, {200, 40}, {200, 150}, {250, 150}, {250, 200}}};
  outline.head = {{{100, 140}, {100, 40}, {200, 40}, {200, 140}}};
  return outline;
}

Image8 boxes(int width, int height, std::initializer_list<std::array<int, 4>> all) {
  Image8 picture(width, height, 1);
  for (const auto& [left, top, right, bottom] : all)
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) *picture.at(x, y) = 255;
  return picture;
}

const SquareCrop kAll{0, 0, 300};  // reaches beyond the picture of 300 x 200

TEST(MarkedMattes, WhatWasDrawnHasNoErrorNorWhatIsAPixelLargerOrSmaller) {
  const DrawnPerson drawn = draw_marks(drawn_figure(), 300, 200);
  for (const int more : {0, 1, -1}) {
    const Image8 found =
        boxes(300, 300, {{50 - more, 150 - more, 250 + more, 300}, {100 - more, 40 - more, 200 + more, 160}});
    const MarkedMatte m = compare_with_marks(found, kAll, drawn);
    EXPECT_DOUBLE_EQ(m.person_iou, 1) << more;
    EXPECT_DOUBLE_EQ(m.head_iou, 1) << more;
    EXPECT_DOUBLE_EQ(m.torso_iou, 1) << more;
  }
}

TEST(MarkedMattes, WhatIsMissingFromTheHeadIsTheHeadsErrorAlone) {
  const DrawnPerson drawn = draw_marks(drawn_figure(), 300, 200);
  const Image8 found = boxes(300, 300, {{50, 150, 250, 300}, {100, 60, 200, 150}});  // 20 px of hair
  const MarkedMatte m = compare_with_marks(found, kAll, drawn);
  EXPECT_NEAR(m.head_iou, 1 - 19.0 / 99, 1e-9);  // rows; the upper two are the edge
  EXPECT_DOUBLE_EQ(m.torso_iou, 1);
  EXPECT_GT(m.person_iou, m.head_iou);
  EXPECT_LT(m.person_iou, 1);
}

TEST(MarkedMattes, WallBesideTheHeadIsTheHeadsErrorAlone) {
  const DrawnPerson drawn = draw_marks(drawn_figure(), 300, 200);
  const Image8 found = boxes(300, 300, {{50, 150, 250, 300}, {100, 20, 200, 150}});
  const MarkedMatte m = compare_with_marks(found, kAll, drawn);
  EXPECT_NEAR(m.head_iou, 99.0 * 98 / (99 * 98 + 19 * 100), 1e-9);
  EXPECT_DOUBLE_EQ(m.torso_iou, 1);
}

TEST(MarkedMattes, OnlyTheCropCountsAtAnySizeOfTheMatte) {
  const DrawnPerson drawn = draw_marks(drawn_figure(), 300, 200);
  const SquareCrop square{90, 30, 120};
  const Image8 source = crop(boxes(300, 300, {{50, 150, 250, 300}, {100, 40, 200, 150}}), square.x, square.y,
                             square.side, square.side);
  for (const int size : {60, 120, 240}) {
    const MarkedMatte m = compare_with_marks(resize(source, size, size), square, drawn);
    EXPECT_NEAR(m.person_iou, 1, size < 120 ? 0.005 : 0) << size;
  }
}

class StudyMarkedMattes : public testing::Test {
 protected:
  fs::path folder_ = fs::temp_directory_path() / ("likeness_marked_" + std::to_string(::getpid()));
  Project project_;
  PersonMarks marks_{"a.mp4", "0f", 300, 200, {drawn_figure(3), drawn_figure(9)}};

  void SetUp() override {
    fs::create_directories(folder_ / "masks");
    project_.folder = folder_;
    Capture capture;
    capture.video = "a.mp4", capture.video_hash = "0f";
    capture.width = 300, capture.height = 200, capture.frames_per_second = 25;
    capture.crop = kAll;
    for (const int frame : {3, 9})
      capture.frames.push_back({.frame = frame, .time_s = frame / 25.0, .used = true});
    ASSERT_TRUE(write_capture(capture_path(project_), capture));
    ASSERT_TRUE(write_image(folder_ / "masks" / "000003.png",
                            boxes(300, 300, {{50, 150, 250, 300}, {100, 40, 200, 150}})));
  }
  void TearDown() override { fs::remove_all(folder_); }
};

TEST_F(StudyMarkedMattes, TakesTheFramesThatHaveAMatteAndNamesTheOthers) {
  const auto result = study_marked_mattes(project_, marks_, {}, {});
  ASSERT_TRUE(result) << result.error().what;
  ASSERT_EQ(result->frames.size(), 1u);
  EXPECT_EQ(result->frames[0].frame, 3);
  EXPECT_DOUBLE_EQ(result->frames[0].person_iou, 1);
  EXPECT_EQ(result->without_matte, std::vector<int>{9});
}

TEST_F(StudyMarkedMattes, RefusesMarksOfAnotherClipAndAProjectWithoutMattes) {
  PersonMarks other = marks_;
  other.video_hash = "1f";
  const auto refused = study_marked_mattes(project_, other, {}, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("a.mp4"), std::string::npos) << refused.error().what;
  fs::remove(folder_ / "masks" / "000003.png");
  EXPECT_FALSE(study_marked_mattes(project_, marks_, {}, {}));
}

TEST_F(StudyMarkedMattes, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  const auto result = study_marked_mattes(project_, marks_, {}, stop.get_token());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace likeness
