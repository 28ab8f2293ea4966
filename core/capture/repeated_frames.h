// Frames that show the picture of the frame before them once more: a film at 24 frames a second in a file of
// 30, a recording of a screen, a camera that could not keep up.
#pragma once

#include <vector>

#include "core/image/image.h"

namespace likeness {

// How much each frame of a clip differs from the one before it.
class DifferenceMeter {
 public:
  // Luma or RGB. Mean difference, 8-bit units; 0 of the first frame.
  float add(const Image8& picture);

 private:
  std::vector<std::uint8_t> before_;
};

// Whether each frame repeats the one before it, from those differences: a small part of its neighbours' on
// both sides, as neither noise nor a pause in a movement leaves it. None repeats where only a few would:
// repeats come in a rhythm.
std::vector<char> repeated_frames(const std::vector<float>& differences);

}  // namespace likeness
