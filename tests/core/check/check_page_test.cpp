// Claims about the page: its verdict has its colour, a remark's picture is one that shows the fault, and what
// is drawn follows the measures.
#include "core/check/check_page.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "core/video/encode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 40;

// Frames of one colour each: so that what is drawn of which can be recognised.
Image8 frame_picture(int frame) {
  Image8 picture(320, 240, 3);
  for (std::size_t i = 0; i < picture.pixels(); ++i) {
    picture.data[3 * i] = std::uint8_t(30 + 5 * frame);
    picture.data[3 * i + 1] = 60;
    picture.data[3 * i + 2] = std::uint8_t(230 - 5 * frame);
  }
  return picture;
}

class CheckPage : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("likeness_check_page_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    auto writer = VideoWriter::create(folder_ / "clip.mp4", 320, 240, {20, 10});
    ASSERT_TRUE(writer.ok());
    for (int i = 0; i < kFrames; ++i) ASSERT_TRUE(writer->add(frame_picture(i)).ok());
    ASSERT_TRUE(writer->finish().ok());
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static ClipMeasures measures() {
    ClipMeasures clip;
    clip.info = *probe_video(folder_ / "clip.mp4");
    clip.frames = kFrames, clip.duration_s = 20;
    clip.camera = {true, 0.4, 0.5, {1, 0}, 200};
    for (int i = 0; i < kFrames; ++i) {
      Look look;
      look.frame = i, look.time_s = 0.5 * i;
      look.face = FaceBox{110, 70, 100, 100, 1};
      look.sharpness = 300, look.level = 120, look.posed = true;
      look.yaw_deg = 40 * std::sin(0.3 * i), look.pitch_deg = 12 * std::cos(0.3 * i);
      clip.looks.push_back(look);
    }
    return clip;
  }
  static Image8 draw(const ClipMeasures& clip, const CaptureVerdict& verdict) {
    const auto page = draw_check_page(folder_ / "clip.mp4", clip, verdict, {}, {});
    EXPECT_TRUE(page.ok()) << (page ? "" : page.error().what);
    return page ? *page : Image8();
  }
  // Number of pixels of the page with about this colour.
  static int count(const Image8& page, int r, int g, int b) {
    int pixels = 0;
    for (std::size_t i = 0; i < page.pixels(); ++i)
      pixels += std::abs(page.data[3 * i] - r) < 5 && std::abs(page.data[3 * i + 1] - g) < 5 &&
                std::abs(page.data[3 * i + 2] - b) < 5;
    return pixels;
  }
  static fs::path folder_;
};
fs::path CheckPage::folder_;

TEST_F(CheckPage, TheVerdictHasItsColour) {
  CaptureVerdict verdict;
  const Image8 ready = draw(measures(), verdict);
  ASSERT_EQ(ready.width, 1240);
  const std::uint8_t* good = ready.at(60, 60);
  EXPECT_GT(good[1], good[0] + 40);  // green
  verdict.verdict = Verdict::refilm;
  verdict.remarks.push_back({Fault::too_dark, true, 2, 9, "Dark.", "Turn on a light."});
  const Image8 refilm = draw(measures(), verdict);
  const std::uint8_t* bad = refilm.at(60, 60);
  EXPECT_GT(bad[0], bad[1] + 80);                // red
  EXPECT_GT(refilm.height, ready.height + 100);  // the remark takes its room
}

TEST_F(CheckPage, RemarksPictureShowsTheFault) {
  ClipMeasures clip = measures();
  for (const int i : {22, 23}) clip.looks[std::size_t(i)].sharpness = 2;
  const Remark remark{Fault::blurred, false, 0, 20, "Blurred in places.", "Hold still."};
  EXPECT_EQ(remark_frame(clip, remark), 22);  // the nearer to the middle of the stretch
  CaptureVerdict verdict;
  verdict.verdict = Verdict::usable;
  verdict.remarks.push_back(remark);
  const Image8 page = draw(clip, verdict);
  const Image8 shown = frame_picture(22);
  EXPECT_GT(count(page, shown.data[0], shown.data[1], shown.data[2]), 130 * 130);
}

TEST_F(CheckPage, ClipWithoutAFaceOrALookStillGivesAPage) {
  ClipMeasures clip = measures();
  for (Look& look : clip.looks) look = {.frame = look.frame, .time_s = look.time_s};
  EXPECT_FALSE(draw(clip, judge_capture(clip)).empty());
  clip.looks.clear();
  EXPECT_EQ(remark_frame(clip, {}), -1);
  EXPECT_FALSE(draw(clip, judge_capture(clip)).empty());
}

TEST_F(CheckPage, ABarredClipsPicturesShowTheFilmAlone) {
  ClipMeasures clip = measures();
  for (Look& look : clip.looks) look.face.reset(), look.posed = false;
  const Image8 whole = draw(clip, judge_capture(clip));
  clip.film = {40, 30, 240, 180};
  clip.whole_width = 320, clip.whole_height = 240;
  clip.repeated = 12;
  const Image8 cut = draw(clip, judge_capture(clip));
  EXPECT_NE(whole.data, cut.data);  // the sentence on what serves names bars and repeats
  EXPECT_FALSE(cut.empty());
}

TEST_F(CheckPage, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  const auto page = draw_check_page(folder_ / "clip.mp4", measures(), {}, {}, stop.get_token());
  ASSERT_FALSE(page.ok());
  EXPECT_EQ(page.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace likeness
