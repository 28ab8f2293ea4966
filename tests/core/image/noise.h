// A picture of white noise, of which nothing can be guessed or compressed away.
#pragma once

#include <random>

#include "core/image/image.h"

namespace likeness {

inline Image8 noise(int width, int height, int channels) {
  Image8 image(width, height, channels);
  std::mt19937 random(1);
  for (auto& v : image.data) v = std::uint8_t(random() & 255);
  return image;
}

}  // namespace likeness
