// Whether one picture of the background explains what a clip shows of it: the look back at a camera that is
// said to rest. Tracks on hair or on a curtain may say so; a plate of a camera that moved does not fit its
// own frames.
#pragma once

#include "core/camera/motion.h"

namespace likeness {

struct PlateFit {
  int frames = 0;          // compared
  double unexplained = 0;  // share of them in which too much of the background differs from the plate
  bool holds() const;
};

// The plate is the temporal median where the person is not, brought to each frame's brightness. Frames
// without any background to compare are left out.
PlateFit fit_of_plate(const BackgroundPictures& pictures);

}  // namespace likeness
