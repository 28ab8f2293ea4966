// One-channel pictures most of which is one value, as mattes are: 0 beside the person, 255 within. Kept in
// tiles; a uniform one costs four bytes. Lossless; any pixel is read in constant time.
#pragma once

#include "core/image/image.h"

namespace likeness {

struct TiledMask {
  static constexpr int kTile = 16;  // px, a side

  int width = 0, height = 0;
  // (rows, columns) of tiles: below 256 the value of all its pixels, otherwise 256 + its place in `pixels`. A
  // tile that extends beyond the border repeats the picture's last pixels there.
  std::vector<std::uint32_t> tiles;
  std::vector<std::uint8_t> pixels;  // (mixed tiles, kTile, kTile)

  TiledMask() = default;
  explicit TiledMask(const Image8& image);  // of one channel

  bool empty() const { return tiles.empty(); }
  std::size_t bytes() const { return tiles.size() * sizeof(tiles[0]) + pixels.size(); }
  int columns() const { return (width + kTile - 1) / kTile; }
  std::uint8_t at(int x, int y) const {
    const std::uint32_t tile =
        tiles[std::size_t(y / kTile) * std::size_t(columns()) + std::size_t(x / kTile)];
    if (tile < 256) return std::uint8_t(tile);
    return pixels[(std::size_t(tile - 256) * kTile + std::size_t(y % kTile)) * kTile +
                  std::size_t(x % kTile)];
  }
};

Image8 to_image(const TiledMask& mask);  // (height, width, 1); empty for an empty one

}  // namespace likeness
