// Films of blotches for the claims about cuts: a wall, and a head before it, as functions of place and time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/capture/sketch_film.h"
#include "core/face/landmarks.h"
#include "core/video/decode.h"

namespace likeness::test {

inline constexpr int kSceneWidth = 320, kSceneHeight = 192;  // px
inline constexpr double kSceneRate = 25;

// Smooth blotches, others for every place.
inline double blotches(double x, double y, int place) {
  double level = 120;
  for (int k = 0; k < 6; ++k) {
    const double turn = 2.4 * k + 1.7 * place, wave = 0.05 + 0.025 * k;
    level += 16 * std::sin(wave * (x * std::cos(turn) + y * std::sin(turn)) + 3.1 * k * (place + 1));
  }
  return level;
}

// The wall's brightness at a px of a frame, and where the head's middle is then; no head: nobody is there.
struct MadeFilm {
  std::function<double(double x, double y, int frame)> wall;
  std::function<std::optional<double>(int frame)> head_x{};
  int frames = 40;
  std::function<double(int frame)> light = [](int) { return 1.0; };
  std::function<std::array<double, 2>(int frame)> slide{};  // px right and down of all there is
  double rate = kSceneRate;
};

inline constexpr double kMadeHeadY = 90, kMadeFace = 70;  // px: its middle's height, and its size

inline std::array<double, 2> made_slide(const MadeFilm& film, int frame) {
  return film.slide ? film.slide(frame) : std::array{0.0, 0.0};
}

inline std::optional<FaceBox> made_face(const MadeFilm& film, int frame) {
  const auto x = film.head_x ? film.head_x(frame) : std::nullopt;
  if (!x) return std::nullopt;
  const auto [right, down] = made_slide(film, frame);
  return FaceBox{*x + right - kMadeFace / 2, kMadeHeadY + down - kMadeFace / 2, kMadeFace, kMadeFace, 1};
}

inline double made_level(const MadeFilm& film, double x, double y, int frame) {
  if (const auto head = film.head_x ? film.head_x(frame) : std::nullopt) {
    const double dx = x - *head, dy = y - kMadeHeadY;
    if (std::hypot(dx, dy) < 0.7 * kMadeFace) return 0.8 * blotches(1.5 * dx, 1.5 * dy, 7);
    if (dy > 40 && std::abs(dx) < 50 + 0.3 * dy) return 40 + 0.2 * blotches(dx, dy, 9);  // clothes
  }
  return film.wall(x, y, frame);
}

// As import sketches it, the face known in every frame that has one.
inline std::vector<FrameSketch> sketches_of(const MadeFilm& film) {
  VideoInfo info;
  info.width = kSceneWidth, info.height = kSceneHeight;
  FilmSketcher sketcher(info);
  for (int f = 0; f < film.frames; ++f) {
    VideoFrame frame;
    const auto [right, down] = made_slide(film, f);
    frame.index = f, frame.time_s = f / film.rate, frame.rgb = Image8(kSceneWidth, kSceneHeight, 1);
    for (int y = 0; y < kSceneHeight; ++y)
      for (int x = 0; x < kSceneWidth; ++x)
        *frame.rgb.at(x, y) = std::uint8_t(
            std::clamp(std::lround(film.light(f) * made_level(film, x - right, y - down, f)), 0L, 255L));
    sketcher.add(frame, made_face(film, f));
  }
  return sketcher.take();
}

}  // namespace likeness::test
