// Claims about the files that phones write: whatever the container, the codec, the rate and the range of
// tones, the pictures are upright, with the right colours and times. The ffmpeg program makes the files.
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/base/files.h"
#include "core/video/decode.h"
#include "tests/core/video/tag_rotation.h"
#include "tests/core/video/video_test_clip.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class PhoneFile : public InFolder {
 protected:
  static bool runs(const std::string& command) {
    return std::system((command + " > /dev/null 2>&1").c_str()) == 0;
  }
  static bool encodes(const std::string& encoder) {
    return runs("ffmpeg -hide_banner -encoders | grep -qw " + encoder);
  }
  bool ffmpeg(const std::string& arguments) const {
    return std::system(
               ("cd '" + folder_.string() + "' && ffmpeg -y -loglevel error " + arguments + " > log.txt 2>&1")
                   .c_str()) == 0;
  }
};

void expect_quadrants(const Image8& rgb, int tolerance, const std::string& what) {
  const int w = rgb.width, h = rgb.height;
  const struct {
    int x, y, colour[3];
  } spots[] = {
      {w / 4, h / 4, {200, 30, 40}}, {3 * w / 4, h / 4, {30, 180, 60}}, {w / 4, 3 * h / 4, {20, 50, 210}}};
  for (const auto& spot : spots)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(rgb.at(spot.x, spot.y)[c], spot.colour[c], tolerance)
          << what << " at " << spot.x << ", " << spot.y;
}

// Every frame in order, each at its time; returns how many there were.
int read_all(const fs::path& file, double rate, const std::string& what) {
  auto reader = VideoReader::open(file);
  EXPECT_TRUE(reader.ok()) << what << ": " << (reader ? "" : reader.error().what);
  if (!reader) return 0;
  for (int i = 0;; ++i) {
    const auto frame = reader->next();
    EXPECT_TRUE(frame.ok()) << what << ": " << (frame ? "" : frame.error().what);
    if (!frame || !*frame) return i;
    EXPECT_EQ((*frame)->index, i) << what;
    EXPECT_NEAR((*frame)->time_s, i / rate, 2e-3) << what;
    EXPECT_EQ((*frame)->rgb.width, reader->info().width) << what;
    expect_quadrants((*frame)->rgb, 9, what);
  }
}

TEST_F(PhoneFile, EveryContainerAndCodecGivesTheSamePictures) {
  if (!runs("ffmpeg -version")) GTEST_SKIP() << "needs the ffmpeg program";
  write_clip(folder_ / "a.mp4", 128, 96, 12, 30);
  const struct {
    const char *encoder, *arguments, *name;
  } cases[] = {
      {"libx264", "-c:v libx264 -crf 10 -bf 2", "h264.mov"},
      {"libx264", "-c:v libx264 -crf 10 -bf 3", "h264.mkv"},
      {"libx265", "-c:v libx265 -crf 10 -x265-params log-level=none -tag:v hvc1", "hevc.mov"},
      {"libx265", "-c:v libx265 -crf 10 -x265-params log-level=none", "hevc.mp4"},
      {"libx265", "-c:v libx265 -crf 10 -x265-params log-level=none -pix_fmt yuv420p10le", "hevc10.mkv"},
      {"libvpx-vp9", "-c:v libvpx-vp9 -crf 10 -b:v 0 -deadline realtime", "vp9.webm"},
      {"libvpx-vp9", "-c:v libvpx-vp9 -crf 10 -b:v 0 -deadline realtime", "vp9.mp4"},
      {"libsvtav1", "-c:v libsvtav1 -crf 15 -preset 10", "av1.mp4"},
      {"libsvtav1", "-c:v libsvtav1 -crf 15 -preset 10", "av1.webm"},
      {"libsvtav1", "-c:v libsvtav1 -crf 15 -preset 10", "av1.mkv"}};
  int made = 0;
  for (const auto& c : cases) {
    if (!encodes(c.encoder)) continue;
    ASSERT_TRUE(ffmpeg(std::string("-i a.mp4 ") + c.arguments + " " + c.name)) << c.name;
    EXPECT_EQ(read_all(folder_ / c.name, 30, c.name), 12) << c.name;
    ++made;
  }
  if (made < 10) GTEST_SKIP() << made << " of 10 kinds of file: this ffmpeg encodes no others";
}

TEST_F(PhoneFile, APortraitFilmIsUprightInEveryContainerThatTagsIt) {
  if (!runs("ffmpeg -version") || !encodes("libx265")) GTEST_SKIP() << "needs the ffmpeg program with x265";
  // Filmed with the phone upright: the sensor lies on its side, and the tag turns its pictures back.
  write_clip(folder_ / "upright.mp4", 96, 128, 6, 30);
  ASSERT_TRUE(ffmpeg("-i upright.mp4 -vf transpose=1 -crf 8 lying.mp4"));
  ASSERT_TRUE(ffmpeg("-i lying.mp4 -c:v libx265 -crf 8 -x265-params log-level=none -tag:v hvc1 lying.mov"));
  for (const char* name : {"lying.mp4", "lying.mov"}) {
    const std::string out = std::string("tagged_") + name;
    ASSERT_TRUE(test::tag_rotation(folder_, name, out, 90));
    EXPECT_EQ(read_all(folder_ / out, 30, out), 6);
    const auto info = probe_video(folder_ / out);
    ASSERT_TRUE(info.ok());
    EXPECT_EQ(info->width, 96) << out;
    EXPECT_EQ(info->height, 128) << out;
  }
}

TEST_F(PhoneFile, SlowMotionKeepsAllItsTimes) {
  write_clip(folder_ / "fast.mp4", 96, 64, 120, 240);
  const auto info = probe_video(folder_ / "fast.mp4");
  ASSERT_TRUE(info.ok()) << info.error().what;
  EXPECT_NEAR(info->frames_per_second, 240, 0.5);
  EXPECT_EQ(read_all(folder_ / "fast.mp4", 240, "240 frames a second"), 120);
}

TEST_F(PhoneFile, SampledReaderKeepsTheNumbersAndTimesOfAFastFilmsFrames) {
  write_clip(folder_ / "fast.mp4", 96, 64, 50, 240);
  auto all = VideoReader::open(folder_ / "fast.mp4");
  auto some = VideoReader::open(folder_ / "fast.mp4", VideoPixels::rgb, VideoFrames::sampled);
  ASSERT_TRUE(all.ok() && some.ok());
  std::vector<int> numbers;
  for (int i = 0; i < 50; ++i) {
    const auto frame = all->next();
    ASSERT_TRUE(frame.ok() && frame->has_value());
    if (i % 8 != 0) continue;
    const auto sampled = some->next();
    ASSERT_TRUE(sampled.ok() && sampled->has_value());
    numbers.push_back((*sampled)->index);
    EXPECT_EQ((*sampled)->time_s, (*frame)->time_s);
    EXPECT_EQ((*sampled)->rgb.data, (*frame)->rgb.data);
  }
  EXPECT_EQ(numbers, (std::vector<int>{0, 8, 16, 24, 32, 40, 48}));
  EXPECT_FALSE(some->next()->has_value());
}

TEST(SamplingStride, LeavesUsualClipsWholeAndBoundsLongOnes) {
  const auto stride = [](double rate, double seconds) {
    VideoInfo info;
    info.frames_per_second = rate;
    info.frame_count = int(rate * seconds);
    return sampling_stride(info);
  };
  EXPECT_EQ(stride(25, 60), 1);
  EXPECT_EQ(stride(60, 150), 1);
  EXPECT_EQ(stride(0, 0), 1);  // nothing known
  EXPECT_EQ(stride(120, 20), 4);
  EXPECT_EQ(stride(240, 60), 8);
  for (const double hours : {0.5, 1.0, 5.0})
    for (const double rate : {24.0, 60.0, 240.0})
      EXPECT_LE(rate * hours * 3600 / stride(rate, hours * 3600), 9000) << rate << " " << hours;
}

TEST_F(PhoneFile, ARateThatVariesKeepsItsTimesInMatroskaToo) {
  if (!runs("ffmpeg -version")) GTEST_SKIP() << "needs the ffmpeg program";
  write_clip(folder_ / "a.mp4", 64, 64, 21);  // the last one may be cut off: see decode_test.cpp
  for (const char* name : {"v.mkv", "v.mov", "v.webm"}) {
    const std::string codec = std::string(name) == "v.webm" ? "-c:v libvpx-vp9 -deadline realtime " : "";
    if (!codec.empty() && !encodes("libvpx-vp9")) continue;
    ASSERT_TRUE(
        ffmpeg("-i a.mp4 -vf \"setpts='if(lt(N,10),N/25,0.4+(N-10)*0.12)/TB'\" -vsync vfr " + codec + name));
    auto reader = VideoReader::open(folder_ / name);
    ASSERT_TRUE(reader.ok()) << reader.error().what;
    for (int i = 0; i < 20; ++i) {
      const auto frame = reader->next();
      ASSERT_TRUE(frame.ok() && frame->has_value()) << name << " " << i;
      EXPECT_NEAR((*frame)->time_s, i < 10 ? i / 25.0 : 0.4 + (i - 10) * 0.12, 2e-3) << name << " " << i;
    }
  }
}

// Luma codes of greys, and what sRGB should make of them: diffuse white (PQ 0.58, HLG 0.75) is shown at 0.9
// of full light, what lies below at its share of white.
TEST_F(PhoneFile, TenBitHighDynamicRangeBecomesNaturalGreysInColourAndInLuma) {
  if (!runs("ffmpeg -version") || !encodes("libx265")) GTEST_SKIP() << "needs the ffmpeg program with x265";
  const struct {
    const char* transfer;
    int code, shown;  // 64..940, 0..255
  } cases[] = {{"smpte2084", 64, 0},    {"smpte2084", 400, 102},    {"smpte2084", 572, 243},
               {"arib-std-b67", 64, 0}, {"arib-std-b67", 502, 137}, {"arib-std-b67", 721, 243}};
  for (const auto& c : cases) {
    const std::string what = std::string(c.transfer) + " " + std::to_string(c.code);
    // Two frames of 64 x 64 px, 4:2:0, little-endian; chroma is neutral.
    std::vector<std::byte> raw;
    for (int frame = 0; frame < 2; ++frame)
      for (int i = 0; i < 64 * 64 * 3 / 2; ++i) {
        const int value = i < 64 * 64 ? c.code : 512;
        raw.push_back(std::byte(value & 255));
        raw.push_back(std::byte(value >> 8));
      }
    ASSERT_TRUE(write_file(folder_ / "grey.yuv", raw));
    ASSERT_TRUE(
        ffmpeg(std::string("-f rawvideo -pix_fmt yuv420p10le -s 64x64 -r 30 -i grey.yuv -c:v libx265 "
                           "-x265-params lossless=1:log-level=none -tag:v hvc1 -vf setparams=range=tv:"
                           "color_primaries=bt2020:colorspace=bt2020nc:color_trc=") +
               c.transfer + " hdr.mov"))
        << what;
    for (const VideoPixels pixels : {VideoPixels::rgb, VideoPixels::luma}) {
      auto reader = VideoReader::open(folder_ / "hdr.mov", pixels);
      ASSERT_TRUE(reader.ok()) << reader.error().what;
      const auto frame = reader->next();
      ASSERT_TRUE(frame.ok() && frame->has_value()) << what;
      for (int channel = 0; channel < (*frame)->rgb.channels; ++channel)
        EXPECT_NEAR((*frame)->rgb.at(32, 32)[channel], c.shown, 3)
            << what << (pixels == VideoPixels::luma ? " luma" : " colour");
    }
  }
}

}  // namespace
}  // namespace likeness
