// Pictures that bring their own mask: what it hides may have any colour, and nobody was meant to see it.
#pragma once

#include "core/image/image.h"

namespace likeness {

inline constexpr std::uint8_t kBackdrop = 128;  // of all channels, where a picture is transparent

struct ShownPicture {
  Image8 rgb;  // over the backdrop
  // One channel, 255 where the picture is opaque; empty: it is so nearly everywhere, or alpha is 0 throughout
  // and thus means nothing.
  Image8 alpha;
};
ShownPicture over_backdrop(const Image8& rgba);

}  // namespace likeness
