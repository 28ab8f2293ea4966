// Claims about bars: found in encoded films, whatever they look like, and not seen where there are none.
#include "core/capture/find_film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "tests/core/capture/demo_film.h"

namespace likeness {
namespace {

using test::demo_pictures;
using test::kDemoSide;

// Every frame of the demo person, changed.
using Change = std::function<Image8(const Image8& frame, int number)>;

PixelRect film_of(const Change& change) {
  const test::FilmFolder folder;
  std::vector<Image8> frames;
  for (std::size_t i = 0; i < demo_pictures().size(); ++i)
    frames.push_back(change(demo_pictures()[i], int(i)));
  test::write_film(folder.path / "film.mp4", frames);
  const auto film = find_film(folder.path / "film.mp4", Progress(), {});
  EXPECT_TRUE(film) << film.error().what;
  return film ? *film : PixelRect{-1, -1, 1, 1};
}

// The frame in the middle of a larger picture of one colour.
Image8 padded(const Image8& frame, int width, int height, std::array<int, 3> colour) {
  Image8 out(width, height, 3);
  for (std::size_t i = 0; i < out.data.size(); ++i) out.data[i] = std::uint8_t(colour[i % 3]);
  const int x0 = (width - frame.width) / 2, y0 = (height - frame.height) / 2;
  for (int y = 0; y < frame.height; ++y) std::copy_n(frame.at(0, y), 3 * frame.width, out.at(x0, y0 + y));
  return out;
}

Image8 darker(const Image8& frame, double share) {
  Image8 out = frame;
  for (std::uint8_t& level : out.data) level = std::uint8_t(share * level);
  return out;
}

// All of what was filmed but a pixel or two at the bars, and nothing else.
void expect_film(const PixelRect& found, const PixelRect& truth) {
  EXPECT_EQ(common_part(found, truth), found)
      << found.x << " " << found.y << " " << found.width << " " << found.height;
  EXPECT_GE(found.width, truth.width - 4);
  EXPECT_GE(found.height, truth.height - 4);
}

TEST(FindFilm, BlackBarsAboveAndBelow) {
  const PixelRect film = film_of([](const Image8& f, int) {
    return padded(f, kDemoSide, kDemoSide + 96, {0, 0, 0});
  });
  expect_film(film, {0, 48, kDemoSide, kDemoSide});
  EXPECT_EQ(film.width, kDemoSide);
}

TEST(FindFilm, ColouredBarsBesideADarkFilm) {
  expect_film(film_of([](const Image8& f, int) {
                return padded(darker(f, 0.2), kDemoSide + 200, kDemoSide, {30, 60, 120});
              }),
              {100, 0, kDemoSide, kDemoSide});
  expect_film(film_of([](const Image8& f, int) {
                return padded(darker(f, 0.3), kDemoSide + 200, kDemoSide, {0, 0, 0});
              }),
              {100, 0, kDemoSide, kDemoSide});
}

TEST(FindFilm, SubtitlesLieInABar) {
  const auto subtitled = [](const Image8& f, int number) {
    Image8 out = padded(f, kDemoSide, kDemoSide + 96, {0, 0, 0});
    if (number / 12 % 3 == 2) return out;  // nobody speaks
    for (int y = kDemoSide + 62; y < kDemoSide + 78; ++y)
      for (int x = 30; x < kDemoSide - 30; ++x)
        if ((x / 5 * 7 + y / 4 * 3 + number / 12) % 5 < 2) std::fill_n(out.at(x, y), 3, 235);
    return out;
  };
  expect_film(film_of(subtitled), {0, 48, kDemoSide, kDemoSide});
}

TEST(FindFilm, ABlurredCopyOnBothSides) {
  const auto beside = [](const Image8& f, int) {
    const Image8 blurred = resize(resize(f, 12, 12), kDemoSide + 200, kDemoSide + 200);
    Image8 out(kDemoSide + 200, kDemoSide, 3);
    for (int y = 0; y < out.height; ++y) std::copy_n(blurred.at(0, y + 100), 3 * out.width, out.at(0, y));
    for (int y = 0; y < f.height; ++y) std::copy_n(f.at(0, y), 3 * f.width, out.at(100, y));
    return out;
  };
  expect_film(film_of(beside), {100, 0, kDemoSide, kDemoSide});
}

TEST(FindFilm, NothingInAFilmWithoutBars) {
  EXPECT_TRUE(film_of([](const Image8& f, int) { return f; }).empty());
}

TEST(FindFilm, ADarkSceneHasNoBars) {
  EXPECT_TRUE(film_of([](const Image8& f, int) { return darker(f, 0.05); }).empty());
  // Black wherever no lamp shines: above and on both sides.
  EXPECT_TRUE(film_of([](const Image8& f, int) {
                Image8 out = f;
                for (int y = 0; y < f.height; ++y)
                  for (int x = 0; x < f.width; ++x) {
                    const double far = std::hypot(x - kDemoSide / 2.0, y - 0.6 * kDemoSide) /
                                       (0.43 * kDemoSide),
                                 light = std::max(0.0, 1 - far);
                    for (int c = 0; c < 3; ++c) out.at(x, y)[c] = std::uint8_t(light * f.at(x, y)[c]);
                  }
                return out;
              }).empty());
}

TEST(FindFilm, APlainWallIsNoBar) {
  // The person before a wall of one level, cut out as a disc that sways.
  EXPECT_TRUE(film_of([](const Image8& f, int number) {
                Image8 out = f;
                const double cx = kDemoSide / 2.0 + 12 * std::sin(number / 9.0);
                for (int y = 0; y < f.height; ++y)
                  for (int x = 0; x < f.width; ++x)
                    if (std::hypot(x - cx, 0.8 * (y - 0.66 * kDemoSide)) > 0.31 * kDemoSide)
                      std::fill_n(out.at(x, y), 3, 231);
                return out;
              }).empty());
}

}  // namespace
}  // namespace likeness
