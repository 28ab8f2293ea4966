// Cutting masks into tiles, and back.
#include "core/image/tiled_mask.h"

#include <algorithm>
#include <array>

#include "core/base/check.h"

namespace likeness {

TiledMask::TiledMask(const Image8& image) : width(image.width), height(image.height) {
  LIKENESS_CHECK(image.empty() || image.channels == 1, "a mask of %d channels", image.channels);
  if (image.empty()) {
    width = height = 0;
    return;
  }
  const int rows = (height + kTile - 1) / kTile;
  tiles.reserve(std::size_t(rows) * std::size_t(columns()));
  for (int top = 0; top < rows * kTile; top += kTile)
    for (int left = 0; left < columns() * kTile; left += kTile) {
      std::array<std::uint8_t, kTile * kTile> tile;
      for (int y = 0; y < kTile; ++y)
        for (int x = 0; x < kTile; ++x)
          tile[std::size_t(y * kTile + x)] =
              *image.at(std::min(left + x, width - 1), std::min(top + y, height - 1));
      if (std::ranges::all_of(tile, [&](std::uint8_t v) { return v == tile[0]; })) {
        tiles.push_back(tile[0]);
      } else {
        tiles.push_back(256 + std::uint32_t(pixels.size() / tile.size()));
        pixels.insert(pixels.end(), tile.begin(), tile.end());
      }
    }
  pixels.shrink_to_fit();
}

Image8 to_image(const TiledMask& mask) {
  if (mask.empty()) return {};
  Image8 image(mask.width, mask.height, 1);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) *image.at(x, y) = mask.at(x, y);
  return image;
}

}  // namespace likeness
