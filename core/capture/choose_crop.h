// One square for a whole clip that holds head and shoulders wherever the head goes.
#pragma once

#include <vector>

#include "core/capture/capture.h"
#include "core/face/landmarks.h"

namespace likeness {

struct CropChoice {
  SquareCrop crop;
  double head_cut_share = 0;  // share of the faces whose top of the head is above the picture's edge
};

// faces: not empty, source px; boxes far from the usual size are left out as mistakes of the detector. The
// square stays inside the picture when the heads fit in one that does.
CropChoice choose_crop(const std::vector<FaceBox>& faces, int width, int height);

}  // namespace likeness
