// Where one picture of a scene lies in another, as a camera that sways, pans or zooms a little leaves them.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image/image.h"

namespace likeness {

// A place u of the first picture is at centre + (1 + scale) (u - centre) + (x, y) in the other; px, the
// centre that of the picture.
struct Placed {
  double x = 0, y = 0, scale = 0;
};

// Two pictures of one size, one channel; free: a pixel each, 1 where they are compared. Gauss-Newton, apart
// from brightness and contrast (Lucas & Kanade 1981), from (0, 0, 0) on: up to about 15 px, and 0.3 of scale.
Placed place_in(const Image8& a, const Image8& b, const std::vector<std::uint8_t>& free);

// The first picture as it lies in the other, its border repeated.
Image8 placed_picture(const Image8& from, const Placed& at);

}  // namespace likeness
