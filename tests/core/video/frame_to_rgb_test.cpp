// Claims about the orientation of frames.
#include "core/video/frame_to_rgb.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

constexpr int kOne = 1 << 16;

// Coded picture, 3 wide and 2 high:  1 2 3
//                                    4 5 6
Image8 coded_picture() {
  Image8 image(3, 2, 1);
  image.data = {1, 2, 3, 4, 5, 6};
  return image;
}

TEST(Orientation, ShowsTheEightWaysAPictureCanLie) {
  struct Case {
    int a, b, c, d;  // of the display matrix, in units of 1
    int clockwise_deg, width;
    std::vector<std::uint8_t> shown;
  };
  const Case cases[] = {
      {1, 0, 0, 1, 0, 3, {1, 2, 3, 4, 5, 6}},     {0, 1, -1, 0, 90, 2, {4, 1, 5, 2, 6, 3}},
      {-1, 0, 0, -1, 180, 3, {6, 5, 4, 3, 2, 1}}, {0, -1, 1, 0, 270, 2, {3, 6, 2, 5, 1, 4}},
      {-1, 0, 0, 1, 180, 3, {3, 2, 1, 6, 5, 4}},  {1, 0, 0, -1, 0, 3, {4, 5, 6, 1, 2, 3}},
      {0, 1, 1, 0, 90, 2, {1, 4, 2, 5, 3, 6}},    {0, -1, -1, 0, 270, 2, {6, 3, 5, 2, 4, 1}},
  };
  for (const Case& c : cases) {
    const Orientation o =
        orientation_from_matrix({c.a * kOne, c.b * kOne, 0, c.c * kOne, c.d * kOne, 0, 0, 0, 1 << 30});
    const Image8 shown = oriented(coded_picture(), o);
    EXPECT_EQ(shown.width, c.width);
    EXPECT_EQ(shown.data, c.shown) << c.a << c.b << c.c << c.d;
    EXPECT_EQ(o.clockwise_deg, c.clockwise_deg);
  }
}

TEST(Orientation, AllZeroesMeansUpright) {
  EXPECT_EQ(oriented(coded_picture(), orientation_from_matrix({})).data, coded_picture().data);
}

}  // namespace
}  // namespace likeness
