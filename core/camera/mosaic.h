// The wall behind the person in colour: one pinhole picture, wider than the frames, in which every frame of a
// hand-held camera finds its background. And how well such a picture explains the background of frames.
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/handheld.h"

namespace likeness {

struct Mosaic {
  Image8 colour;  // RGB
  Image8 known;  // one channel, 255 = seen in enough frames; elsewhere `colour` is black: fill it as you like
  Intrinsics intrinsics;                   // of the mosaic; no distortion
  Pose cam_from_world = Pose::Identity();  // no translation
};

// A frame as its background is read from or compared with a mosaic.
struct MosaicFrame {
  const Image8* colour = nullptr;  // RGB; all of one size
  const Image8* person = nullptr;  // one channel, non-zero = not background; null or empty: nobody
  Camera camera;                   // at the picture's size; only its rotation counts
  double gain = 1, bias = 0;       // the picture is gain * the mosaic's values + bias
};

// Frames of the solve from which to build a mosaic: found, not held out, at most about `most`, which cover
// all that the clip shows.
std::vector<int> mosaic_frames(const HandheldSolve& solve, std::size_t most);

// The mosaic that covers what a solve's frames show, at a source that is `width` by `height`; reduced where
// it would have more than most_pixels.
Intrinsics mosaic_intrinsics(const HandheldSolve& solve, int width, int height, double most_pixels = 12e6);

// Each pixel of each channel: the mean of what lies close to the temporal median over the frames in which the
// person is not there. A pixel is known that a twentieth of the frames that could show it, and at least two
// of them, do show. All pictures stay with the caller; time is about 40 ns a frame and pixel.
Result<Mosaic> build_mosaic(std::span<const MosaicFrame> frames, const Intrinsics& intrinsics,
                            const Progress& progress, std::stop_token stop);

// What a camera sees of it, rotation alone: bilinear, and the mean over a pixel's area where the mosaic is
// finer than the camera. known: 255 where all that counts was known; may be null.
Image8 warp_mosaic(const Mosaic& mosaic, const Camera& to, Image8* known);

// How well a mosaic, or a resting camera's plate, explains a frame's background.
struct LookBack {
  double psnr = 0;     // dB over the background that the mosaic knows; 0 where there is none
  double covered = 0;  // share of the background that it knows
  double off = 0;      // share of that which differs by more than `kLookBackOff` in a channel
};
inline constexpr int kLookBackOff = 24;  // of 255: plain to see, and beyond noise and a codec
// One for each frame.
std::vector<LookBack> look_back(const Mosaic& mosaic, std::span<const MosaicFrame> frames);

// The same of all frames together: psnr of the mean squared error, `covered` and `off` as shares of all.
LookBack look_back_together(const Mosaic& mosaic, std::span<const MosaicFrame> frames);

}  // namespace likeness
