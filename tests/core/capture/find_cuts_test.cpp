// Claims about cuts, on films made of blotches: where they are found, and what is none.
#include "core/capture/find_cuts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "core/capture/capture.h"
#include "tests/core/capture/made_film.h"

namespace likeness {
namespace {

using test::blotches;
using test::MadeFilm;

constexpr int kFilm = 40, kCutAt = 20;

std::vector<FrameSpan> shots_in(std::function<double(double x, double y, int frame)> level,
                                std::function<std::optional<double>(int frame)> head_x = {}) {
  return find_shots(test::sketches_of(MadeFilm{std::move(level), std::move(head_x), kFilm}));
}

double resting_wall(double x, double y, int) { return blotches(x, y, 0); }
// A head that sways a little, px.
double swaying(int f) { return 160 + 2 * std::sin(0.3 * f); }

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

// A call that becomes narrower for a while, or a phone that is turned: whatever it shows.
TEST(FindCuts, AnotherShapeOfPictureBeginsAShot) {
  auto film = test::sketches_of({resting_wall, swaying, kFilm});
  for (int f = kCutAt; f < kCutAt + 3; ++f) film[std::size_t(f)].shape = 1;
  EXPECT_EQ(find_shots(film),
            (std::vector<FrameSpan>{{0, kCutAt - 1}, {kCutAt, kCutAt + 2}, {kCutAt + 3, kFilm - 1}}));
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

TEST(FindCuts, AJumpOfTheHeadBeforeARestingWallBeginsAShot) {
  const auto shots = shots_in(
      resting_wall, [](int f) -> std::optional<double> { return swaying(f) + (f >= kCutAt ? 14 : 0); });
  EXPECT_EQ(shots, (std::vector<FrameSpan>{{0, kCutAt - 1}, {kCutAt, kFilm - 1}}));
}

TEST(FindCuts, AQuickTurnAStepOfTheLampAndAHeadThatReturnsAreNoCuts) {
  const auto quick = [](int f) -> std::optional<double> {
    return swaying(f) + 14 * std::clamp((f - kCutAt) / 4.0, 0.0, 1.0);
  };
  EXPECT_EQ(shots_in(resting_wall, quick), kWhole);
  MadeFilm dimmed{resting_wall, [](int f) -> std::optional<double> { return swaying(f); }, kFilm};
  dimmed.light = [](int f) { return f >= kCutAt ? 0.7 : 1; };
  EXPECT_EQ(find_shots(test::sketches_of(dimmed)), kWhole);
  const auto flash = [](int f) -> std::optional<double> {
    return swaying(f) + (f == kCutAt || f == kCutAt + 1 ? 14 : 0);
  };
  EXPECT_EQ(shots_in(resting_wall, flash), kWhole);
}

// However slowly, and by whatever part of a pixel: what is known of the camera's motion is not exact.
TEST(FindCuts, ACameraThatSlidesPastAPersonAtRestAndComesToRestCutsNothing) {
  for (const auto& [right, down] : {std::array{-2.0, 0.0}, {-1.78, 0.12}, {0.6, -0.45}, {0.1, 2.4}})
    for (const bool whole_px : {false, true}) {
      MadeFilm film{resting_wall, [](int) -> std::optional<double> { return 160; }, kFilm};
      film.rate = 10;
      film.slide = [&](int f) {
        std::array at{right * (std::min(f, kCutAt) - 10), down * (std::min(f, kCutAt) - 10)};
        if (whole_px)
          for (double& px : at) px = std::round(px);
        return at;
      };
      EXPECT_EQ(find_shots(test::sketches_of(film)), kWhole)
          << right << ", " << down << " px" << (whole_px ? ", whole" : "");
    }
}

TEST(FindCuts, AJumpOfTheHeadBeforeACameraThatSlidesBeginsAShot) {
  MadeFilm film{resting_wall,
                [](int f) -> std::optional<double> { return swaying(f) + (f >= kCutAt ? 14 : 0); }, kFilm};
  film.slide = [](int f) { return std::array{0.73 * (f - kCutAt), -0.31 * (f - kCutAt)}; };
  EXPECT_EQ(find_shots(test::sketches_of(film)),
            (std::vector<FrameSpan>{{0, kCutAt - 1}, {kCutAt, kFilm - 1}}));
}

TEST(FindCuts, ADissolveFromACameraThatMovesIsFound) {
  constexpr int kLength = 8;
  const auto shots = shots_in([](double x, double y, int f) {
    const double share = std::clamp(double(f - kCutAt + 1) / (kLength + 1), 0.0, 1.0);
    return (1 - share) * blotches(3 * (x + 0.7 * f), 3 * y, 0) + share * blotches(x, y, 1);
  });
  ASSERT_EQ(shots.size(), 2U);
  EXPECT_NEAR(shots[0].last, kCutAt - 1, 2);
  EXPECT_NEAR(shots[1].first, kCutAt + kLength, 2);
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
