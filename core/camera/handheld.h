// The camera of a clip that a hand held: it sways, turns and zooms about one place, so that what is behind
// the person is one picture - a mosaic of the wall - seen through a turning lens. Solved densely, on grey
// pictures of the background, so that a wall with few corners will do; structure from motion, which needs
// parallax, has nothing to solve here. A crop that slides over a film is such a camera, too.
//
// First every frame is aligned to a mosaic that grows with the frames, from the middle of the clip outwards;
// then, in rounds, the mosaic is rebuilt from all training frames and each frame aligned to it anew, which
// closes what drifted. The camera may only turn and zoom at first. A shift of the principal point (a crop
// that slides, a hand that moves sideways before a wall) does nearly the same as a turn, so it is allowed
// only where pairs of pictures far apart ask for it; if they do not, they tell the focal length. Frames held
// out are aligned last, to the finished mosaic alone: they contribute nothing to it, nor to another frame's
// view. About 7 ms a frame and round on a core at 480 x 270.
#pragma once

#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/camera/handheld_view.h"
#include "core/image/image.h"

namespace likeness {

struct HandheldFrame {
  int frame = 0;                   // number in the source
  const Image8* grey = nullptr;    // one channel; 320 to 480 px wide serve
  const Image8* person = nullptr;  // the same size, non-zero = not background; null or empty: nobody
  bool held_out = false;
  double time_s = 0;
  int shot = 0;  // of a film that was cut: nothing is expected of a frame by those of another
};

struct HandheldOptions {
  double lens_sigma = 0.25;    // of the logarithm of the true focal length over the one given; 0: it is exact
  int rounds = 3;              // of rebuilding the mosaic and aligning to it; fewer where nothing moves more
  double shift_scale = 0.005;  // of the width: a larger shift of the principal point must be plain to see
  double zoom_scale = 0.03;    // of the focal length, likewise
  double smooth_px = 0.15;     // how far frames may leave the line between their neighbours before it counts
                               // as the hand's doing and not as noise
  std::size_t median_of = 160;  // frames, about, that the mosaic is the median of
};

struct HandheldCamera {
  int frame = 0;
  Vec3d rotation = Vec3d::Zero();  // rotation vector of cam_from_world, rad
  double zoom = 1;                 // of the reference's focal length
  Vec2d shift_px = Vec2d::Zero();  // of the principal point, px of the reference
  double gain = 1, bias = 0;       // grey values are gain * mosaic + bias
  double residual = 0;             // rms over the background, each pixel counted as 30 at most; 0..255
  double overlap = 0;              // share of the background that the mosaic knows
  double certainty = 0;            // share of this that agrees with the mosaic, 0..1
  double sigma_px = 0;             // standard deviation of where the background is, by its texture
  int parts = 0;                   // of the background with texture enough to tell where it is
  bool held_out = false;
  bool found = false;  // else it is a guess from the neighbours
};

struct HandheldSolve {
  Intrinsics reference;  // at the size of the pictures given; its focal length is the one found
  std::vector<HandheldCamera> cameras;  // one for each frame given, ascending
  Intrinsics extent;                    // of the mosaic, at the reference's focal lengths
  double residual = 0;                  // median over the frames found
  double noise = 0;                     // of the pictures, from pixel to pixel, in the same units
  double explained = 0;                 // share of the frames found
  double motion = 0;  // how far the background strays from its usual place: 1/1000 of the width, p95
  double zoom_low = 1, zoom_high = 1;  // of the frames found, p2 and p98
  double sigma_px = 0;                 // as of the cameras, upper quartile; large where nothing has texture
  bool shifts = false;                 // the principal point moves, too: turns and zooms did not explain it
  double focal_sigma = 0;  // standard deviation of the logarithm of the focal length that the turns
                           // told; 0: they told none, and it is the one given
  // Of pairs of frames far apart, laid over each other (core/camera/view_pairs.h), that have parts which can
  // tell: by how much these lie elsewhere than the model says, median; the share beyond the limit.
  double misfit_px = 0, misfitting = 0;
  double judged = 0;     // share of the frames found that have parts which can tell
  std::string evidence;  // in words with numbers
};

// Cameras of the frames, ascending in `frame`. An error of bad_input where there is no training frame, or
// where pictures differ in size or have no background at all.
Result<HandheldSolve> solve_handheld(std::span<const HandheldFrame> frames, const Intrinsics& reference,
                                     const HandheldOptions& options, const Progress& progress,
                                     std::stop_token stop);

// Share of a dozen of the frames in which parts of the background have texture enough to be found by
// themselves, before anything is solved. Noise passes for texture here, so it is rather too large.
double share_with_texture(std::span<const HandheldFrame> frames);

// The view of a solved camera, at the reference's size.
HandheldView handheld_view(const HandheldCamera& camera);

// The camera of a frame, at the size of a source of width by height; of the nearest frame where the solve
// has none of this number. The solve has at least one.
Camera handheld_camera(const HandheldSolve& solve, int frame, int width, int height);

}  // namespace likeness
