// What finding a clip's cameras is given: options, and what masks the person.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/frame_span.h"
#include "core/camera/camera.h"
#include "core/image/image.h"
#include "core/image/pixel_rect.h"

namespace likeness {

// Where the person is, coarsely, in source pixels; the caller (core/matte) knows faces, this library does
// not. Given a frame number and its picture: one channel, 255 = ignore.
using PersonMask = std::function<Image8(int frame, const Image8& rgb)>;

struct AlignOptions {
  double static_motion_px_per_1000 = 1.5;  // median background motion, in px per 1000 px of picture width
  std::optional<CameraKind> kind{};        // the user's word; resting: nothing is measured
  std::set<int> held_out{};                // frames that say nothing about a hand-held camera's other ones
  double lens_mm = 0;             // and on its lens, as film_intrinsics takes it; 0: as the clip says
  PixelRect film{};               // what was filmed of the clip's pictures, px; empty: all of them
  int keyframes = 80;             // at most this many go through colmap
  int colmap_width = 540;         // px the keyframes are reduced to; raising it costs quadratically
  int colmap_features = 2000;     // per keyframe
  std::string colmap = "colmap";  // the program: a name looked up in PATH, or a path
  int seed = 0;
  // Of a film that was cut, what shows one place (core/capture/capture.h: stretches_that_serve); the rest is
  // not looked at and gets no camera of its own. Empty: the whole clip.
  std::vector<FrameSpan> stretches{};
  // The shots within them, between which the camera may jump (spans_where_cut). Empty: one.
  std::vector<FrameSpan> shots{};
  // Where import kept what its decoding showed for this (core/camera/kept_path.h); empty: nowhere. Changes no
  // result.
  std::filesystem::path kept{};
  std::string mask_inputs{};  // names what the person mask is made with: kept motion under another is not it
};

// How far the background may stray in a rest, as measure_background_motion takes it.
inline double rest_limit(const AlignOptions& options) { return options.static_motion_px_per_1000 / 2; }

}  // namespace likeness
