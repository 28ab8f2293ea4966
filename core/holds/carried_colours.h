// The colours of one picture of a head, carried over by its surface to another picture: what the other would
// show where both see the same skin, were the face painted on.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/holds/skin_parts.h"
#include "core/image/image.h"

namespace likeness {

// Per pixel of the other picture, row-major.
struct CarriedColours {
  std::vector<std::uint8_t> known;  // 1 where both pictures see the place squarely enough
  std::vector<Vec3f> colour;        // as the first picture has it
};
// from_rgb: (h, w, 3) the picture in which the head is as `from` says. Skin of the face alone.
CarriedColours carry_colours(const HeadInPicture& from, const Image& from_rgb, const HeadInPicture& to);

struct ColourChange {
  double mean = 0;   // |difference| over pixels and channels
  double drift = 0;  // of the part of the face whose mean colour changed most: largest channel
  int pixels = 0;    // compared
};
// Of the other picture, to_rgb, off what is carried to it, in the pictures' own unit. Parts of which fewer
// than least_pixels are known do not count in the drift; 0 where nothing is known.
ColourChange colour_change(const CarriedColours& carried, const HeadInPicture& to, const Image& to_rgb,
                           int least_pixels);

}  // namespace likeness
