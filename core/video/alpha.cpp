// Compositing over the backdrop: see alpha.h.
#include "core/video/alpha.h"

#include <cstddef>

namespace likeness {

ShownPicture over_backdrop(const Image8& rgba) {
  constexpr int kOpaque = 250;
  constexpr double kNearlyEverywhere = 1e-3;  // of the pixels may be otherwise: rounded corners
  ShownPicture shown{Image8(rgba.width, rgba.height, 3), Image8(rgba.width, rgba.height, 1)};
  // Nobody hides a whole picture: its alpha was never filled in.
  bool unused = true;
  for (std::size_t i = 3; unused && i < rgba.data.size(); i += 4) unused = rgba.data[i] == 0;
  std::size_t hidden = 0;
  for (std::size_t i = 0; i < rgba.pixels(); ++i) {
    const std::uint8_t* from = rgba.data.data() + 4 * i;
    const int alpha = unused ? 255 : from[3];
    hidden += alpha < kOpaque;
    shown.alpha.data[i] = std::uint8_t(alpha);
    for (std::size_t c = 0; c < 3; ++c)
      shown.rgb.data[3 * i + c] = std::uint8_t((from[c] * alpha + kBackdrop * (255 - alpha) + 127) / 255);
  }
  if (double(hidden) <= kNearlyEverywhere * double(rgba.pixels())) shown.alpha = {};
  return shown;
}

}  // namespace likeness
