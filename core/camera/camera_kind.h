// What kind of camera a clip was filmed with, by what the hand-held camera explains of it.
#pragma once

#include <string>

#include "core/camera/handheld.h"

namespace likeness {

enum class CameraExplanation {
  resting,      // nothing behind the person moves
  handheld,     // it turns, zooms or shifts about one place
  unexplained,  // it travels: near and far move apart, and structure from motion may find its path
  no_texture    // nothing behind the person can show whether it moves
};

struct CameraVerdict {
  CameraExplanation explanation = CameraExplanation::no_texture;
  std::string reason;  // a sentence or two, with the figures that decided and their limits
};

struct CameraKindLimits {
  // 1/1000 of the width that the background may stray, in all but 5 % of the frames, for a camera at rest:
  // under a pixel at 512 px, which a plate's median forgives; a tripod on a floor with people stays below.
  double resting = 1.5;
  // Share of the frames in which parts of the background have texture enough to be found by themselves.
  double judged = 0.5;
  // Share of the frames that the mosaic must explain: one in ten may be blurred, or mostly hidden.
  double explained = 0.9;
  // Share of the frames that may have parts beyond kMisfitLimit: motion blur and a passer-by make some.
  // Parallax is there in nearly all frames that are away from the middle of the path.
  double misfitting = 0.3;
};

CameraVerdict judge_camera_kind(const HandheldSolve& solve, const CameraKindLimits& limits = {});

}  // namespace likeness
