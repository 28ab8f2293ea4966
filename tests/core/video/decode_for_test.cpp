// Claims about one decoding for several listeners: each sees what a reader of its own would have given, and
// the clip is decoded no more often than is said.
#include "core/video/decode_for.h"

#include <gmock/gmock.h>

#include <vector>

#include "core/base/files.h"
#include "tests/core/video/video_test_clip.h"

namespace likeness {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kClipFrames = 24;
constexpr std::uint64_t kPlenty = std::uint64_t(1) << 30;

class DecodeFor : public InFolder {
 protected:
  void SetUp() override {
    InFolder::SetUp();
    write_clip(clip(), 128, 96, kClipFrames);
  }
  fs::path clip() const { return folder_ / "a.mp4"; }
  std::vector<VideoFrame> frames_alone(VideoPixels pixels) const {
    auto reader = VideoReader::open(clip(), pixels, VideoFrames::sampled);
    EXPECT_TRUE(reader);
    return rest_of(*reader);
  }
  static std::vector<VideoFrame> rest_of(VideoReader& reader) {
    std::vector<VideoFrame> frames;
    while (true) {
      auto next = reader.next();
      EXPECT_TRUE(next) << next.error().what;
      if (!next || !*next) return frames;
      frames.push_back(std::move(**next));
    }
  }
};

void expect_same(const std::vector<VideoFrame>& got, const std::vector<VideoFrame>& wanted) {
  ASSERT_EQ(got.size(), wanted.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_EQ(got[i].index, wanted[i].index);
    EXPECT_EQ(got[i].time_s, wanted[i].time_s);
    EXPECT_EQ(got[i].rgb.channels, wanted[i].rgb.channels);
    EXPECT_EQ(got[i].rgb.data, wanted[i].rgb.data) << "frame " << i;
  }
}

TEST_F(DecodeFor, EachListenerSeesWhatAReaderOfItsOwnGivesOutOfOneDecoding) {
  const auto luma = frames_alone(VideoPixels::luma), rgb = frames_alone(VideoPixels::rgb);
  ASSERT_EQ(luma.size(), std::size_t(kClipFrames));
  std::vector<VideoFrame> seen[3];
  std::vector<FrameListener> listeners;
  for (int i = 0; i < 3; ++i)
    listeners.push_back({i == 1 ? VideoPixels::luma : VideoPixels::rgb, [&seen, i](const VideoFrame& frame) {
                           seen[i].push_back(frame);
                           return Result<void>();
                         }});
  auto reader = VideoReader::open(clip(), pixels_for(listeners), VideoFrames::sampled);
  ASSERT_TRUE(reader);
  const std::int64_t before = decoded_frames();
  ASSERT_TRUE(decode_for(*reader, listeners, {}));
  EXPECT_EQ(decoded_frames() - before, kClipFrames);
  expect_same(seen[0], rgb);
  expect_same(seen[1], luma);
  expect_same(seen[2], rgb);
}

TEST_F(DecodeFor, TheFirstErrorEndsItAndIsGivenBack) {
  int looks = 0;
  const std::vector<FrameListener> listeners{{VideoPixels::luma,
                                              [&](const VideoFrame&) {
                                                ++looks;
                                                return Result<void>();
                                              }},
                                             {VideoPixels::luma, [](const VideoFrame& frame) -> Result<void> {
                                                if (frame.index < 3) return {};
                                                return Error{ErrorCode::io, "The disk is full.", "", ""};
                                              }}};
  auto reader = VideoReader::open(clip(), pixels_for(listeners));
  ASSERT_TRUE(reader);
  const auto ended = decode_for(*reader, listeners, {});
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().what, "The disk is full.");
  EXPECT_EQ(looks, 4);
}

TEST_F(DecodeFor, AStopAndATruncatedClipSayWhatAReaderSays) {
  const std::vector<FrameListener> listeners{
      {VideoPixels::rgb, [](const VideoFrame&) { return Result<void>(); }}};
  std::stop_source stop;
  stop.request_stop();
  auto reader = VideoReader::open(clip());
  ASSERT_TRUE(reader);
  EXPECT_EQ(decode_for(*reader, listeners, stop.get_token()).error().code, ErrorCode::cancelled);

  const auto bytes = read_file(clip());
  ASSERT_TRUE(bytes);
  ASSERT_TRUE(write_file(folder_ / "cut.mp4", std::span(*bytes).first(bytes->size() * 6 / 10)));
  auto cut = VideoReader::open(folder_ / "cut.mp4");
  ASSERT_TRUE(cut) << cut.error().what;
  const auto ended = decode_for(*cut, listeners, {});
  ASSERT_FALSE(ended);
  EXPECT_THAT(ended.error().what, HasSubstr("The video is cut short"));
  // Rewound, it says the same, kept frames or not.
  ASSERT_TRUE(cut->rewind(VideoPixels::rgb));
  const auto again = decode_for(*cut, listeners, {});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().what, ended.error().what);
}

TEST_F(DecodeFor, KeptFramesAreNotDecodedASecondTime) {
  auto reader = VideoReader::open(clip(), VideoPixels::luma, VideoFrames::sampled);
  ASSERT_TRUE(reader);
  const auto rgb = frames_alone(VideoPixels::rgb);
  reader->keep_frames(kPlenty);
  const std::int64_t before = decoded_frames();
  expect_same(rest_of(*reader), frames_alone(VideoPixels::luma));
  ASSERT_TRUE(reader->rewind(VideoPixels::rgb));
  expect_same(rest_of(*reader), rgb);
  EXPECT_EQ(decoded_frames() - before, 2 * kClipFrames);  // this reader's once, frames_alone()'s once
  // They left memory with that: a third time, the clip is decoded.
  ASSERT_TRUE(reader->rewind(VideoPixels::rgb));
  expect_same(rest_of(*reader), rgb);
  EXPECT_EQ(decoded_frames() - before, 3 * kClipFrames);
}

TEST_F(DecodeFor, WithoutRoomForAllFramesTheClipIsDecodedAgain) {
  const auto rgb = frames_alone(VideoPixels::rgb);
  // None are begun with; or it shows only on the way, since a decoder pads its frames.
  const std::uint64_t bare = std::uint64_t(128) * 96 * 3 / 2 * kClipFrames;
  for (const std::uint64_t room : {std::uint64_t(0), bare / 2, bare}) {
    auto reader = VideoReader::open(clip(), VideoPixels::rgb, VideoFrames::sampled);
    ASSERT_TRUE(reader);
    reader->keep_frames(room);
    const std::int64_t before = decoded_frames();
    expect_same(rest_of(*reader), rgb);
    ASSERT_TRUE(reader->rewind(VideoPixels::rgb));
    expect_same(rest_of(*reader), rgb);
    EXPECT_EQ(decoded_frames() - before, 2 * kClipFrames) << room;
  }
}

TEST_F(DecodeFor, AClipLeftInTheMiddleBeginsAgainAtItsFirstFrame) {
  auto reader = VideoReader::open(clip(), VideoPixels::rgb, VideoFrames::sampled);
  ASSERT_TRUE(reader);
  reader->keep_frames(kPlenty);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(reader->next());
  ASSERT_TRUE(reader->rewind(VideoPixels::luma));
  expect_same(rest_of(*reader), frames_alone(VideoPixels::luma));
}

}  // namespace
}  // namespace likeness
