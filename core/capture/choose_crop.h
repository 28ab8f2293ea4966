// One square for a whole clip that holds head and shoulders wherever the head goes, within what was filmed.
#pragma once

#include <vector>

#include "core/capture/capture.h"
#include "core/face/landmarks.h"
#include "core/image/pixel_rect.h"

namespace likeness {

struct CropChoice {
  SquareCrop crop;
  double head_cut_share = 0;  // share of the faces whose top of the head is above the film's edge
};

// faces: not empty, in the order of the clip, source px; boxes far from the usual size are left out as
// mistakes of the detector. film: what was filmed, source px. The square stays within it where the heads fit
// into one that does, even if shoulders are lost: what it would reach beyond is unknown. Only heads larger
// than the film's shorter side, or that stray further, get a larger square, in whose direction the film ends.
CropChoice choose_crop(const std::vector<FaceBox>& faces, const PixelRect& film);

}  // namespace likeness
