// Claims about capture.json: an exact round trip, and refusal of anything else.
#include "core/capture/capture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/base/files.h"

namespace likeness {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

Capture example() {
  Capture c;
  c.video = "/somewhere/Zoë's clip.mp4";
  c.video_hash = "0123456789abcdef";
  c.width = 1080, c.height = 1920;
  c.frames_per_second = 30000.0 / 1001;
  c.crop = {-12, 40, 1000};
  c.size = 512;
  c.warnings = {"one", "two \"quoted\""};
  for (int i = 0; i < 10; ++i) {
    CaptureFrame f{i, i / 29.97, 100.0 / (i + 3), i >= 9, i < 9 && i != 4, i == 4 ? "Blurred." : ""};
    c.frames.push_back(f);
  }
  return c;
}

class CaptureFile : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = fs::temp_directory_path() /
            std::string("likeness_capture_").append(std::to_string(getpid())).append(".json");
  }
  void TearDown() override { fs::remove(path_); }
  Error error_for(const std::string& text) {
    EXPECT_TRUE(write_text(path_, text));
    const auto read = read_capture(path_);
    return read ? Error{ErrorCode::failed, "no error", "", ""} : read.error();
  }
  fs::path path_;
};

// Of old disks and archives.
TEST_F(CaptureFile, AClipWhoseNameIsNoTextIsFoundAgain) {
  Capture c = example();
  c.video = "/clips/m\xfcller.mp4";
  ASSERT_TRUE(write_capture(path_, c));
  const auto read = read_capture(path_);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->video.native(), c.video.native());
}

TEST_F(CaptureFile, TheTimeOfAFrameIsItsOwn) {
  Capture c = example();
  c.frames[7].time_s = 3.5;
  EXPECT_EQ(time_of_frame(c, 7), 3.5);
  EXPECT_NEAR(time_of_frame(c, 60), 2, 0.01) << "of a frame that was not read";
}

TEST_F(CaptureFile, GivesBackExactlyWhatWasWritten) {
  const Capture c = example();
  ASSERT_TRUE(write_capture(path_, c));
  const auto read = read_capture(path_);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->video, c.video);
  EXPECT_EQ(read->video_hash, c.video_hash);
  EXPECT_EQ(read->width, c.width);
  EXPECT_EQ(read->height, c.height);
  EXPECT_EQ(read->frames_per_second, c.frames_per_second);
  EXPECT_EQ(read->crop.x, c.crop.x);
  EXPECT_EQ(read->crop.y, c.crop.y);
  EXPECT_EQ(read->crop.side, c.crop.side);
  EXPECT_EQ(read->size, c.size);
  EXPECT_EQ(read->split, Split::tail);
  EXPECT_EQ(read->warnings, c.warnings);
  ASSERT_EQ(read->frames.size(), c.frames.size());
  for (std::size_t i = 0; i < c.frames.size(); ++i) {
    EXPECT_EQ(read->frames[i].frame, c.frames[i].frame);
    EXPECT_EQ(read->frames[i].time_s, c.frames[i].time_s);
    EXPECT_EQ(read->frames[i].sharpness, c.frames[i].sharpness);
    EXPECT_EQ(read->frames[i].held_out, c.frames[i].held_out);
    EXPECT_EQ(read->frames[i].used, c.frames[i].used);
    EXPECT_EQ(read->frames[i].refused, c.frames[i].refused);
  }
  EXPECT_EQ(held_out_frames(*read), std::set<int>{9});
}

TEST_F(CaptureFile, KeepsTheViewsOfTheSplitThatGoesByThem) {
  Capture c = example();
  ASSERT_TRUE(write_capture(path_, c));
  for (const char* key : {"view", "apart", "sides"})  // as in files from before it
    EXPECT_EQ(read_text(path_)->find(std::string("\"") + key + '"'), std::string::npos) << key;
  c.split = Split::sides, c.sides = {7.5, 16};
  c.frames[2].view = {-12.25, 3.5};
  c.frames[2].used = false, c.frames[2].apart = true, c.frames[2].refused = "Seen from between.";
  ASSERT_TRUE(write_capture(path_, c));
  const auto read = read_capture(path_);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->split, Split::sides);
  EXPECT_EQ(read->sides, c.sides);
  ASSERT_TRUE(read->frames[2].view);
  EXPECT_EQ(read->frames[2].view->yaw_deg, -12.25);
  EXPECT_EQ(read->frames[2].view->pitch_deg, 3.5);
  EXPECT_TRUE(read->frames[2].apart);
  EXPECT_FALSE(read->frames[1].view);
  EXPECT_EQ(held_out_frames(*read), std::set<int>{9});
  EXPECT_EQ(silent_frames(*read), (std::set<int>{c.frames[2].frame, 9}));
  c.frames[2].used = true;
  ASSERT_TRUE(write_capture(path_, c));
  EXPECT_FALSE(read_capture(path_));
}

TEST_F(CaptureFile, SaysWhatWasFilmedOfThePicturesOnlyWhereNotAllWas) {
  Capture c = example();
  ASSERT_TRUE(write_capture(path_, c));
  EXPECT_EQ(read_text(path_)->find("inside"), std::string::npos);  // as in files from before it
  EXPECT_TRUE(read_capture(path_)->inside.empty());
  c.inside = {7, 0, 505, 500};
  ASSERT_TRUE(write_capture(path_, c));
  EXPECT_EQ(read_capture(path_)->inside, c.inside);
  EXPECT_TRUE(read_capture(path_)->film.empty());
  c.film = {0, 140, 1080, 1640};
  ASSERT_TRUE(write_capture(path_, c));
  EXPECT_EQ(read_capture(path_)->film, c.film);
  EXPECT_EQ(tracked_part(c), (PixelRect{0, 140, 988, 900}));
  for (const PixelRect wrong : {PixelRect{-1, 0, 20, 20}, {0, 500, 20, 20}, {3, 3, 2147483647, 5}}) {
    c.inside = wrong;
    ASSERT_TRUE(write_capture(path_, c));
    const auto read = read_capture(path_);
    ASSERT_FALSE(read);
    EXPECT_THAT(read.error().what, HasSubstr("filmed"));
  }
}

TEST(FilmedPart, IsTheWholePixelsThatTheFilmFills) {
  const PixelRect film{0, 0, 400, 300};
  EXPECT_TRUE(filmed_part({100, 20, 280}, film, 256).empty());
  // 50 px above and below of 400: 32 of 256.
  EXPECT_EQ(filmed_part({0, -50, 400}, film, 256), (PixelRect{0, 32, 256, 192}));
  // A pixel that the film fills in part is left out on both sides.
  EXPECT_EQ(filmed_part({0, -51, 400}, film, 256), (PixelRect{0, 33, 256, 191}));
  EXPECT_EQ(filmed_part({-10, 0, 300}, film, 100), (PixelRect{4, 0, 96, 100}));
}

TEST_F(CaptureFile, RefusesOtherFilesWithTheReason) {
  ASSERT_TRUE(write_capture(path_, example()));
  const std::string good = *read_text(path_);

  fs::remove(path_);
  EXPECT_EQ(read_capture(path_).error().code, ErrorCode::not_found);
  EXPECT_EQ(error_for("").code, ErrorCode::bad_input);
  EXPECT_EQ(error_for("{\"format\": \"something else\"}").code, ErrorCode::bad_input);
  EXPECT_EQ(error_for("[1, 2, 3]").code, ErrorCode::bad_input);
  for (const double share : {0.2, 0.6, 0.95}) {
    EXPECT_EQ(error_for(good.substr(0, std::size_t(double(good.size()) * share))).code, ErrorCode::bad_input);
  }
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  EXPECT_THAT(error_for(with("\"version\": 1", "\"version\": 7")).what, HasSubstr("version 7"));
  EXPECT_THAT(error_for(with("\"side_px\": 1000", "\"side_px\": -3")).what, HasSubstr("not positive"));
  for (const char* side : {"2000000000", "1e300", "65000"})
    EXPECT_EQ(error_for(with("\"side_px\": 1000", std::string("\"side_px\": ") + side)).code,
              ErrorCode::bad_input);
  EXPECT_THAT(error_for(with("\"frame\": 3,", "\"frame\": 2,")).what, HasSubstr("ascending"));
  EXPECT_EQ(error_for(with("\"size_px\": 512", "\"size_px\": \"large\"")).code, ErrorCode::bad_input);
  EXPECT_FALSE(error_for("{}").fix.empty());
}

TEST(FrameName, HasSixDigitsInTheFramesFolder) {
  EXPECT_EQ(frame_name(123), fs::path("frames/000123.png"));
  EXPECT_EQ(frame_name(0), fs::path("frames/000000.png"));
}

}  // namespace
}  // namespace likeness
