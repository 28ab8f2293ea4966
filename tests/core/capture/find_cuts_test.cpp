// Claims about cuts, on films made of blotches: where they are found, and what is none.
#include "core/capture/find_cuts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/capture/capture.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

constexpr int kSceneWidth = 320, kSceneHeight = 192, kFilm = 40, kCutAt = 20;

// Smooth blotches, others for every place.
double blotches(double x, double y, int place) {
  double level = 120;
  for (int k = 0; k < 6; ++k) {
    const double turn = 2.4 * k + 1.7 * place, wave = 0.05 + 0.025 * k;
    level += 16 * std::sin(wave * (x * std::cos(turn) + y * std::sin(turn)) + 3.1 * k * (place + 1));
  }
  return level;
}

using Level = std::function<double(double x, double y, int frame)>;

std::vector<FrameSpan> shots_in(const Level& level) {
  VideoInfo info;
  info.width = kSceneWidth, info.height = kSceneHeight;
  FilmSketcher sketcher(info);
  for (int f = 0; f < kFilm; ++f) {
    VideoFrame frame;
    frame.index = f, frame.time_s = f / 25.0, frame.rgb = Image8(kSceneWidth, kSceneHeight, 1);
    for (int y = 0; y < kSceneHeight; ++y)
      for (int x = 0; x < kSceneWidth; ++x)
        *frame.rgb.at(x, y) = std::uint8_t(std::clamp(std::lround(level(x, y, f)), 0L, 255L));
    sketcher.add(frame, std::nullopt);
  }
  return find_shots(sketcher.take());
}

const std::vector<FrameSpan> kWhole{{0, kFilm - 1}};

TEST(FindCuts, AnotherPlaceBeginsAShotAtItsVeryFrame) {
  const auto shots = shots_in([](double x, double y, int f) { return blotches(x, y, f >= kCutAt); });
  EXPECT_EQ(shots, (std::vector<FrameSpan>{{0, kCutAt - 1}, {kCutAt, kFilm - 1}}));
}

TEST(FindCuts, ACloserCropBeginsAShot) {
  const auto shots = shots_in([](double x, double y, int f) {
    const double zoom = f >= kCutAt ? 1.3 : 1;
    return blotches((x - 160) / zoom + 160, (y - 96) / zoom + 96, 0);
  });
  EXPECT_EQ(shots, (std::vector<FrameSpan>{{0, kCutAt - 1}, {kCutAt, kFilm - 1}}));
}

TEST(FindCuts, AFlashAnExposureStepAPanAndNothingAreNoCuts) {
  EXPECT_EQ(shots_in([](double x, double y, int) { return blotches(x, y, 0); }), kWhole);
  EXPECT_EQ(shots_in([](double x, double y, int f) { return blotches(x, y, 0) + (f == kCutAt ? 150 : 0); }),
            kWhole);
  EXPECT_EQ(shots_in([](double x, double y, int f) { return blotches(x, y, 0) * (f >= kCutAt ? 0.6 : 1); }),
            kWhole);
  EXPECT_EQ(shots_in([](double x, double y, int f) { return blotches(x + 2 * f, y, 0); }), kWhole);
}

TEST(FindCuts, TheFramesOfADissolveBelongToNoShot) {
  constexpr int kLength = 10;
  const auto shots = shots_in([](double x, double y, int f) {
    const double share = std::clamp(double(f - kCutAt + 1) / (kLength + 1), 0.0, 1.0);
    return (1 - share) * blotches(x, y, 0) + share * blotches(x, y, 1);
  });
  ASSERT_EQ(shots.size(), 2U);
  EXPECT_NEAR(shots[0].last, kCutAt - 1, 1);
  EXPECT_NEAR(shots[1].first, kCutAt + kLength, 1);
}

TEST(Capture, CutsInPlaceJoinAndLeftOutShotsPart) {
  Capture capture;
  for (int f = 0; f < 30; ++f) capture.frames.push_back({f, f / 25.0, 100, false, true, ""});
  capture.shots = {
      {0, 9, 0, 0.4, true, ""}, {10, 19, 0.4, 0.8, true, ""}, {20, 29, 0.8, 1.2, false, "no face"}};
  EXPECT_EQ(spans_where_cut(capture), (std::vector<FrameSpan>{{0, 9}, {10, 19}}));
  EXPECT_EQ(stretches_that_serve(capture), (std::vector<FrameSpan>{{0, 19}}));
  capture.shots[2].used = true;
  EXPECT_EQ(spans_where_cut(capture).size(), 3U);
  EXPECT_TRUE(stretches_that_serve(capture).empty());
}

}  // namespace
}  // namespace likeness
