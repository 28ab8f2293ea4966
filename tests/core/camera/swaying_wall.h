// Pictures of a wall at infinity by a camera whose turns, zooms and shifts are known, with noise, changing
// exposure, and a person who wanders about before it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "core/base/rigid.h"
#include "core/camera/handheld.h"
#include "core/image/image.h"
#include "tests/core/camera/textured_room.h"

namespace likeness {

// Grey value, 0..255, of the wall in a direction, given where a camera that looks straight ahead shows it,
// px.
using Wall = std::function<double(double u, double v)>;

inline double textured_wall(double u, double v) {
  return 20 + 200.0 * wall_texture(u / 1.6, v / 1.6, 3);  // details of 4 and 13 px
}
// No corner anywhere: light from two windows.
inline double shaded_wall(double u, double v) {
  return 120 + 50 * std::sin(u * 0.021 + 0.006 * v) + 40 * std::sin(v * 0.027 - 0.004 * u + 1);
}
inline double blank_wall(double, double) { return 140; }

struct SwayingClip {
  Intrinsics lens;
  std::vector<HandheldView> truth;
  std::vector<Image8> greys, persons;

  std::vector<HandheldFrame> frames() const {
    std::vector<HandheldFrame> all;
    for (std::size_t i = 0; i < greys.size(); ++i)
      all.push_back({int(i), &greys[i], persons.empty() ? nullptr : &persons[i], false, double(i) / 30});
    return all;
  }
};

inline Intrinsics sway_lens(int width = 240, int height = 136) {
  Intrinsics k;
  k.width = width, k.height = height;
  k.fx = k.fy = 1.4 * std::min(width, height);
  k.cx = width / 2.0, k.cy = height / 2.0;
  return k;
}

struct SwayOptions {
  Wall wall = textured_wall;
  double noise = 2;        // grey values
  double exposure = 0.06;  // share by which the gain drifts to either side
  bool person = true;
  double masked = 1.15;  // size of the mask over the person's; below 1 a rim of the person is left
  int seed = 1;
};

// Turns of up to `degrees` to the sides, half up and down, a third about the lens, at the rates of a hand.
inline HandheldView hand_sway(double t, double degrees, double zoom = 0) {
  const double a = degrees / 57.29578;
  HandheldView view;
  view.turn = turn_from_vector({0.5 * a * std::sin(2.1 * t + 0.4), a * std::sin(1.3 * t) * std::cos(0.17 * t),
                                a / 3 * std::sin(0.9 * t)});
  view.log_zoom = zoom * std::sin(0.5 * t);
  return view;
}

inline Image8 wall_picture(const Intrinsics& lens, const HandheldView& view, const Wall& wall, double gain,
                           double noise, std::mt19937& random) {
  Image8 picture(lens.width, lens.height, 1);
  const auto map = view_map<double>(lens, lens, view);
  std::normal_distribution<double> spread(0, noise > 0 ? noise : 1);
  for (int y = 0; y < lens.height; ++y)
    for (int x = 0; x < lens.width; ++x) {
      const auto place = view_place(map, x + 0.5, y + 0.5);
      const double off = noise > 0 ? spread(random) : 0;
      *picture.at(x, y) = std::uint8_t(std::clamp(gain * wall(place.u, place.v) + off + 0.5, 0.0, 255.0));
    }
  return picture;
}

// A disc with a texture of its own, moving on its own; and the mask of it.
inline void draw_wanderer(Image8& picture, Image8& mask, int frame, double masked) {
  const double radius = 0.27 * picture.height;
  const double cx = picture.width * (0.5 + 0.08 * std::sin(frame * 0.21)),
               cy = picture.height * (0.6 + 0.05 * std::cos(frame * 0.33));
  mask = Image8(picture.width, picture.height, 1);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const double off = std::hypot(x - cx, y - cy);
      if (off < radius) *picture.at(x, y) = std::uint8_t(220 * wall_texture(x - cx, y - cy, 11));
      if (off < radius * masked) *mask.at(x, y) = 255;
    }
}

inline SwayingClip swaying_clip(const Intrinsics& lens, int count,
                                const std::function<HandheldView(int)>& view,
                                const SwayOptions& options = {}) {
  SwayingClip clip;
  clip.lens = lens;
  std::mt19937 random(std::uint32_t(options.seed));
  for (int i = 0; i < count; ++i) {
    clip.truth.push_back(view(i));
    clip.greys.push_back(wall_picture(lens, clip.truth.back(), options.wall,
                                      1 + options.exposure * std::sin(i * 0.07), options.noise, random));
    if (!options.person) continue;
    clip.persons.emplace_back();
    draw_wanderer(clip.greys.back(), clip.persons.back(), i, options.masked);
  }
  return clip;
}

// How far a solve's cameras are from the truth, frame against frame, since the world's axes are free.
struct SwayErrors {
  double turn_deg = 0;  // largest, against the middle frame
  double zoom = 0;      // largest relative error, against the middle frame
  double place_px = 0;  // largest distance in the picture between where the two put the same piece of wall
};
inline SwayErrors sway_errors(const SwayingClip& clip, const HandheldSolve& solve,
                              const std::vector<int>& which) {
  SwayErrors errors;
  const std::size_t middle = clip.truth.size() / 2;
  const HandheldView from = handheld_view(solve.cameras[middle]), true_from = clip.truth[middle];
  for (const int i : which) {
    const HandheldView view = handheld_view(solve.cameras[std::size_t(i)]),
                       truth = clip.truth[std::size_t(i)];
    const Mat3d turn = view.turn * from.turn.transpose(), true_turn = truth.turn * true_from.turn.transpose();
    errors.turn_deg = std::max(errors.turn_deg, 57.29578 * rotation_angle(turn * true_turn.transpose()));
    errors.zoom = std::max(errors.zoom, std::abs(std::expm1((view.log_zoom - from.log_zoom) -
                                                            (truth.log_zoom - true_from.log_zoom))));
    for (const double sx : {0.2, 0.8})
      for (const double sy : {0.2, 0.8}) {
        // A place of the middle frame, followed into this one by both.
        const Vec3d at(sx * clip.lens.width, sy * clip.lens.height, 1);
        const auto follow = [&](const Intrinsics& lens, const HandheldView& a, const HandheldView& b,
                                const Mat3d& b_from_a) {
          const Intrinsics ka = view_intrinsics(lens, a), kb = view_intrinsics(lens, b);
          const Vec3d ray((at.x() - ka.cx) / ka.fx, (at.y() - ka.cy) / ka.fy, 1);
          return project<double>(kb, Vec3d(b_from_a * ray));
        };
        errors.place_px = std::max(errors.place_px, (follow(solve.reference, from, view, turn) -
                                                     follow(clip.lens, true_from, truth, true_turn))
                                                        .norm());
      }
  }
  return errors;
}
inline std::vector<int> all_of(const SwayingClip& clip) {
  std::vector<int> which(clip.truth.size());
  for (std::size_t i = 0; i < which.size(); ++i) which[i] = int(i);
  return which;
}

}  // namespace likeness
