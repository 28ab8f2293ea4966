// What of a mosaic lies behind a training picture's pixel, for processor and device. Plain C++17. The picture
// as a whole: core/camera/mosaic.h.
#pragma once

#include <cstdint>

#include "core/base/host_device.h"

namespace likeness {

struct MosaicPlace {
  float from_pixel[9];         // (3, 3) row by row, pixels of the view to those of the mosaic, homogeneous
  std::int32_t width, height;  // px of the mosaic; 0: there is none
};

// The colour, [0, 1], bilinear; known: whether every pixel that it is made of was seen, which none is that
// lies outside. fetch(x, y): red, green, blue from the lowest byte, and above them 255 where it was seen.
template <class Fetch>
LIKENESS_HOST_DEVICE void mosaic_colour(const MosaicPlace& place, int x, int y, const Fetch& fetch,
                                        float (&out)[3], bool& known) {
  const float* m = place.from_pixel;
  const float px = float(x) + 0.5f, py = float(y) + 0.5f;
  const float w = m[6] * px + m[7] * py + m[8], safe = w > 1e-6f ? w : 1e-6f;
  const float u = (m[0] * px + m[1] * py + m[2]) / safe - 0.5f,
              v = (m[3] * px + m[4] * py + m[5]) / safe - 0.5f;
  const float right = float(place.width - 1), bottom = float(place.height - 1);
  known = w > 1e-6f && u > -0.5f && v > -0.5f && u < right + 0.5f && v < bottom + 0.5f;
  const float cu = u > 0 ? (u < right ? u : right) : 0, cv = v > 0 ? (v < bottom ? v : bottom) : 0;
  const int x0 = int(cu), y0 = int(cv), x1 = x0 + 1 < place.width ? x0 + 1 : x0,
            y1 = y0 + 1 < place.height ? y0 + 1 : y0;
  const float a = cu - float(x0), b = cv - float(y0);
  const std::uint32_t pixels[4] = {fetch(x0, y0), fetch(x1, y0), fetch(x0, y1), fetch(x1, y1)};
  const float weights[4] = {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b};
  for (int c = 0; c < 3; ++c) {
    float sum = 0;
    for (int i = 0; i < 4; ++i) sum += weights[i] * float(pixels[i] >> (8 * c) & 255u);
    out[c] = sum / 255.f;
  }
  for (int i = 0; i < 4; ++i) known = known && pixels[i] >> 24 == 255u;
}

}  // namespace likeness
