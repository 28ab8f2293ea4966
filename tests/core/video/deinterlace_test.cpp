// Claims about interlaced films: known by their lines, made progressive, and others left as they are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/image/metrics.h"
#include "core/video/decode.h"
#include "tests/core/video/video_test_clip.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 224, kHeight = 160, kFrames = 40;

double texture(double x, double y) {
  return 0.5 + 0.2 * std::sin(0.31 * x + 0.12 * y) + 0.2 * std::sin(0.17 * y - 0.23 * x) +
         0.1 * std::sin(0.9 * x) * std::sin(0.7 * y);
}

// A textured disc that swings in front of a textured wall; time in frames.
Image8 picture(double time) {
  Image8 image(kWidth, kHeight, 3);
  const double cx = 112 + 40 * std::sin(0.2 * time), cy = 80 + 8 * std::sin(0.13 * time);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool disc = std::hypot(x - cx, y - cy) < 45;
      const double level = disc ? 90 + 150 * texture(x - cx + 500, 2 * (y - cy)) : 20 + 120 * texture(x, y);
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = std::uint8_t(std::clamp(level - 10 * c, 0.0, 255.0));
    }
  return image;
}

// Even lines of a frame's moment, odd ones of half a frame later.
Image8 interlaced(int frame) {
  Image8 image = picture(frame);
  const Image8 later = picture(frame + 0.5);
  for (int y = 1; y < kHeight; y += 2) std::copy_n(later.at(0, y), 3 * kWidth, image.at(0, y));
  return image;
}

class Deinterlace : public InFolder {
 protected:
  template <class Frame>
  fs::path write(const std::string& name, const Frame& frame) const {
    auto writer = VideoWriter::create(folder_ / name, kWidth, kHeight, {.crf = 8});
    EXPECT_TRUE(writer);
    for (int i = 0; i < kFrames; ++i) EXPECT_TRUE(writer->add(frame(i)));
    EXPECT_TRUE(writer->finish());
    return folder_ / name;
  }
  struct Read {
    bool interlaced = false;
    double mse = 0;  // to the pictures of the frames' moments, mean
    int frames = 0;
    std::int64_t decoded = 0;
  };
  static Read read(const fs::path& path) {
    Read out;
    const std::int64_t before = decoded_frames();
    auto reader = VideoReader::open(path);
    EXPECT_TRUE(reader);
    while (reader) {
      const auto next = reader->next();
      EXPECT_TRUE(next);
      if (!next || !*next) break;
      EXPECT_EQ((*next)->index, out.frames);
      EXPECT_NEAR((*next)->time_s, out.frames / 25.0, 1e-6);
      out.mse += mse(to_float((*next)->rgb), to_float(picture(out.frames++)));
    }
    out.interlaced = reader->was_interlaced();
    out.decoded = decoded_frames() - before;
    out.mse /= std::max(1, out.frames);
    return out;
  }
};

TEST_F(Deinterlace, LinesOfTwoMomentsBecomeOnePicture) {
  const auto now = [](int i) { return picture(i); };
  const Read whole = read(write("whole.mp4", now)), woven = read(write("woven.mp4", interlaced));
  double left = 0;  // without doing anything
  for (int i = 0; i < kFrames; ++i) left += mse(to_float(interlaced(i)), to_float(picture(i))) / kFrames;
  EXPECT_FALSE(whole.interlaced);
  EXPECT_TRUE(woven.interlaced);
  EXPECT_LT(woven.mse, 0.15 * left);
  EXPECT_EQ(woven.frames, kFrames);
  EXPECT_EQ(woven.decoded, kFrames);  // nothing is decoded twice to find out
  EXPECT_EQ(whole.decoded, kFrames);
}

TEST_F(Deinterlace, WhatRestsKeepsAllItsLines) {
  const auto resting = [](int i) { return i < 4 ? interlaced(i) : interlaced(4); };
  auto reader = VideoReader::open(write("rest.mp4", resting));
  ASSERT_TRUE(reader);
  for (int i = 0; i < kFrames; ++i) {
    const auto next = reader->next();
    ASSERT_TRUE(next && *next);
    if (i < 8) continue;
    EXPECT_LT(mse(to_float((*next)->rgb), to_float(interlaced(4))), 1e-4) << i;
  }
  EXPECT_TRUE(reader->was_interlaced());
}

TEST_F(Deinterlace, KeptFramesAreTheSame) {
  const fs::path path = write("woven.mp4", interlaced);
  std::vector<Image8> passes[2];
  auto reader = VideoReader::open(path);
  ASSERT_TRUE(reader);
  reader->keep_frames(std::uint64_t(1) << 30);
  for (std::vector<Image8>& pass : passes) {
    while (true) {
      auto next = reader->next();
      ASSERT_TRUE(next);
      if (!*next) break;
      pass.push_back((*next)->rgb);
    }
    ASSERT_TRUE(reader->rewind(VideoPixels::rgb));
  }
  ASSERT_EQ(passes[0].size(), std::size_t(kFrames));
  ASSERT_EQ(passes[1].size(), std::size_t(kFrames));
  for (int i = 0; i < kFrames; ++i)
    EXPECT_EQ(passes[0][std::size_t(i)].data, passes[1][std::size_t(i)].data) << i;
}

// As a camera writes it, and a file that only says so.
TEST_F(Deinterlace, AFlagIsBelievedUnlessTheFramesShowOtherwise) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "there is no ffmpeg";
  const auto flagged = [&](const std::string& name) {
    const std::string command = "cd '" + folder_.string() + "' && ffmpeg -y -loglevel error -i " + name +
                                ".mp4 -c:v libx264 -crf 8 -flags +ildct+ilme -x264opts tff=1 " + name +
                                "_flagged.mp4";
    EXPECT_EQ(std::system(command.c_str()), 0);
    return folder_ / (name + "_flagged.mp4");
  };
  write("woven.mp4", interlaced);
  write("whole.mp4", [](int i) { return picture(i); });
  EXPECT_TRUE(read(flagged("woven")).interlaced);
  EXPECT_FALSE(read(flagged("whole")).interlaced);
}

}  // namespace
}  // namespace likeness
