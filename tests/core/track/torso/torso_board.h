// A textured board where a torso is expected, in a camera's view below the chin, that moves and sags in known
// ways.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/track/torso/torso.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {

inline constexpr double kDepth = 0.66;  // m, where track_torso expects a chest whose head is at 0.7

inline Intrinsics view() { return {256, 256, 400, 400, 128, 128}; }

// How one side of the board sinks when it deforms, m per unit of `sag`.
inline double sunk(double x) { return 0.006 / (1 + std::exp(-40 * (x - 0.03))); }

// The board turned by `roll` in the picture about (0, 0.1), moved by (dx, dy) and, from the camera, `away`
// metres and deformed.
inline Image8 board(double dx, double dy, double roll, double sag = 0, double away = 0) {
  const Intrinsics k = view();
  const double depth = kDepth + away;
  Image8 image(k.width, k.height, 1);
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const double bx = (x + 0.5 - k.cx) / k.fx * depth - dx,
                   by = (y + 0.5 - k.cy) / k.fy * depth - dy - 0.1 -
                        sag * sunk((x + 0.5 - k.cx) / k.fx * depth);
      const double u = std::cos(roll) * bx + std::sin(roll) * by,
                   v = -std::sin(roll) * bx + std::cos(roll) * by;
      const double value = 128 + 50 * std::sin(70 * u + 1) * std::cos(60 * v) + 40 * std::sin(35 * (u + v));
      image.at(x, y)[0] = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
    }
  return image;
}

struct BoardClip {
  std::vector<Image8> images;
  std::vector<TorsoFrame> frames;
};

inline BoardClip show(std::vector<Image8> images) {
  BoardClip clip;
  clip.images = std::move(images);
  for (const Image8& image : clip.images) {
    TorsoFrame f;
    f.grey = &image;
    f.usable = true;
    f.intrinsics = view();
    f.world_from_head = facing_pose(0, 0, {0, -0.1, 0.7});
    clip.frames.push_back(f);
  }
  return clip;
}

inline BoardClip make_clip(const std::vector<Vec3d>& motions) {  // dx, dy, roll
  std::vector<Image8> images;
  for (const Vec3d& m : motions) images.push_back(board(m.x(), m.y(), m.z()));
  return show(std::move(images));
}

// 30 training frames and 6 held out, which shift and sag in ways of their own.
inline double shift_of(int i) { return 0.004 * std::sin(0.7 * i); }
inline double sag_of(int i) { return std::sin(0.45 * i + 1); }
inline BoardClip sagging_clip() {
  std::vector<Image8> images;
  for (int i = 0; i < 36; ++i) images.push_back(board(shift_of(i), 0, 0, sag_of(i)));
  BoardClip clip = show(std::move(images));
  for (std::size_t i = 30; i < 36; ++i) clip.frames[i].held_out = true;
  return clip;
}

inline const Vec3d kChin(0, -0.08, 0.09);

}  // namespace likeness
