// Claims about recording, with a stand-in for the camera.
#include "core/video/record.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/video/decode.h"
#include "core/video/webcam.h"
#include "tests/core/video/video_test_clip.h"

namespace likeness {
namespace {

class Record : public InFolder {};

// Delivers a picture at each of the times; the grey quadrant identifies it.
class Playback : public FrameSource {
 public:
  explicit Playback(std::vector<double> times, int width = 64) : times_(std::move(times)), width_(width) {}
  Result<std::optional<CapturedFrame>> next(std::stop_token) override {
    if (at_ >= times_.size()) return std::optional<CapturedFrame>();
    CapturedFrame picture{quadrant_frame(at_ + 1 == odd_ ? 32 : width_, 48, int(at_)), times_[at_], {}};
    ++at_;
    return std::optional(std::move(picture));
  }
  std::string name() const override { return "playback"; }
  void change_size_at(std::size_t picture) { odd_ = picture + 1; }

 private:
  std::vector<double> times_;
  std::size_t at_ = 0, odd_ = 0;
  int width_;
};

// Which picture each frame of a file shows.
std::vector<int> shown(const std::filesystem::path& file) {
  std::vector<int> pictures;
  auto reader = VideoReader::open(file);
  EXPECT_TRUE(reader.ok());
  while (reader) {
    const auto frame = reader->next();
    if (!frame || !*frame) break;
    pictures.push_back(int(std::lround(((*frame)->rgb.at(48, 36)[0] - 40) / 5.0)));
  }
  return pictures;
}

TEST_F(Record, PicturesAreWrittenAtTheirTimes) {
  // 10 a second: on time, late by one slot, two within one slot, on time again.
  Playback camera({5.0, 5.1, 5.3, 5.4, 5.43, 5.5});
  const auto recording = record_clip(camera, folder_ / "a.mp4", {.frames_per_second = 10, .crf = 8}, {}, {});
  ASSERT_TRUE(recording.ok()) << recording.error().what;
  EXPECT_EQ(shown(folder_ / "a.mp4"), (std::vector<int>{0, 1, 1, 2, 3, 5}));
  EXPECT_EQ(recording->frames, 6);
  EXPECT_EQ(recording->repeated, 1);
  EXPECT_EQ(recording->left_out, 1);
  EXPECT_NEAR(recording->seconds, 0.6, 1e-9);
}

TEST_F(Record, ALongGapStaysAsLong) {
  Playback camera({0, 0.1, 60.0, 60.1});
  const auto recording = record_clip(camera, folder_ / "a.mp4", {.frames_per_second = 10, .crf = 8}, {}, {});
  ASSERT_TRUE(recording.ok()) << recording.error().what;
  EXPECT_EQ(recording->frames, 4);
  EXPECT_NEAR(recording->seconds, 60.2, 1e-9);
  EXPECT_EQ(shown(folder_ / "a.mp4"), (std::vector<int>{0, 1, 2, 3}));
  auto reader = VideoReader::open(folder_ / "a.mp4");
  ASSERT_TRUE(reader.ok());
  for (const double time_s : {0.0, 0.1, 60.0, 60.1}) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame && *frame);
    EXPECT_NEAR((*frame)->time_s, time_s, 1e-3);
  }
}

TEST_F(Record, AStopKeepsWhatWasRecordedAndTheTimeIsLimited) {
  std::vector<double> times;
  for (int i = 0; i < 30; ++i) times.push_back(0.1 * i);
  std::stop_source stop;
  int seen = 0;
  Playback camera(times);
  const auto stopped = record_clip(
      camera, folder_ / "a.mp4", {.frames_per_second = 10},
      [&](const CapturedFrame&) {
        if (++seen == 12) stop.request_stop();
      },
      stop.get_token());
  ASSERT_TRUE(stopped.ok()) << stopped.error().what;
  EXPECT_EQ(stopped->frames, 12);
  EXPECT_EQ(shown(folder_ / "a.mp4").size(), 12u);
  Playback again(times);
  const auto limited =
      record_clip(again, folder_ / "b.mp4", {.frames_per_second = 10, .longest_s = 2}, {}, {});
  ASSERT_TRUE(limited.ok());
  EXPECT_EQ(limited->frames, 20);
}

TEST_F(Record, ChangedCameraKeepsWhatWasRecorded) {
  Playback changing({0, 0.1, 0.2});
  changing.change_size_at(2);
  const auto changed = record_clip(changing, folder_ / "a.mp4", {}, {}, {});
  ASSERT_TRUE(changed.ok());
  ASSERT_TRUE(changed->interruption);
  EXPECT_NE(changed->interruption->what.find("64 x 48 to 32 x 48"), std::string::npos)
      << changed->interruption->what;
  EXPECT_GT(changed->frames, 0);
  EXPECT_EQ(files(), 1u);
}

TEST_F(Record, NeverReplacesAFile) {
  std::ofstream(folder_ / "a.mp4") << "mine";
  Playback source({0, 0.1, 0.2});
  const auto refused = record_clip(source, folder_ / "a.mp4", {}, {}, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(std::filesystem::file_size(folder_ / "a.mp4"), 4u);
}

TEST_F(Record, ASilentCameraLeavesNoFile) {
  Playback silent({});
  const auto nothing = record_clip(silent, folder_ / "a.mp4", {}, {}, {});
  ASSERT_FALSE(nothing.ok());
  EXPECT_FALSE(nothing.error().fix.empty());
  EXPECT_EQ(files(), 0u);
}

TEST_F(Record, ReportsAMissingWebcam) {
  const auto none = open_webcam("/dev/video_that_is_not", kToRecord);
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::not_found);
  EXPECT_FALSE(none.error().fix.empty());
  for (const Webcam& webcam : list_webcams()) EXPECT_TRUE(webcam.device.starts_with("/dev/video"));
}

}  // namespace
}  // namespace likeness
