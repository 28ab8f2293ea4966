// Claims about masks in tiles.
#include "core/image/tiled_mask.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace likeness {
namespace {

TEST(TiledMask, RoundTripsEveryPixelWhateverTheSize) {
  std::mt19937 random(1);
  for (const auto& [width, height] : {std::pair{1, 1}, {16, 16}, {17, 31}, {64, 48}, {100, 5}}) {
    Image8 noise(width, height, 1);
    for (auto& v : noise.data) v = random() % 3 == 0 ? std::uint8_t(random()) : std::uint8_t(255);
    const Image8 again = to_image(TiledMask(noise));
    EXPECT_EQ(again.width, width);
    EXPECT_EQ(again.height, height);
    EXPECT_EQ(again.channels, 1);
    EXPECT_EQ(again.data, noise.data) << width << "x" << height;
  }
}

TEST(TiledMask, AnEvenTileCostsFourBytes) {
  for (const int value : {0, 7, 255}) {
    const TiledMask even(Image8(256, 250, 1, std::uint8_t(value)));
    EXPECT_TRUE(even.pixels.empty()) << value;
    EXPECT_EQ(even.bytes(), 16u * 16 * 4);
    EXPECT_EQ(even.at(255, 249), value);
  }
  Image8 disc(256, 256, 1);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x)
      *disc.at(x, y) = std::uint8_t(std::clamp(255 * (80 - std::hypot(x - 128, y - 128)), 0.0, 255.0));
  EXPECT_LT(TiledMask(disc).bytes(), disc.data.size() / 4);
}

TEST(TiledMask, OfNothingIsEmpty) {
  EXPECT_TRUE(TiledMask().empty());
  EXPECT_TRUE(TiledMask(Image8()).empty());
  EXPECT_TRUE(to_image(TiledMask()).empty());
}

}  // namespace
}  // namespace likeness
