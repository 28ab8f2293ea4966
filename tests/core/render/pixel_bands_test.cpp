// Claims about pictures rendered at a part of their size.
#include "core/render/pixel_bands.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

TEST(EdgePixels, AreThoseOnBothSidesOfAStep) {
  Image picture(6, 3, 4);
  for (int y = 0; y < 3; ++y)
    for (int x = 3; x < 6; ++x) picture.at(x, y)[2] = 0.5f;
  const auto edges = edge_pixels(picture, 0.4f, 100);
  ASSERT_EQ(edges.size(), 6u);
  for (std::size_t i = 0; i < edges.size(); ++i)
    EXPECT_EQ(edges[i], Eigen::Vector2i(i % 2 == 0 ? 2 : 3, int(i / 2)));
  EXPECT_TRUE(edge_pixels(picture, 0.5f, 100).empty());
}

TEST(EdgePixels, OfTooManyAreThoseThatDifferTheMost) {
  Image picture(9, 1, 1);
  for (int x = 0; x < 9; ++x) picture.at(x, 0)[0] = float(x * x) / 64;  // steps grow with x
  EXPECT_EQ(edge_pixels(picture, 0.f, 3), (std::vector<Eigen::Vector2i>{{6, 0}, {7, 0}, {8, 0}}));
  EXPECT_TRUE(edge_pixels(picture, 0.f, 1).empty());  // 7 and 8 have the same step
  EXPECT_TRUE(edge_pixels(picture, 0.f, 0).empty());
  EXPECT_EQ(edge_pixels(picture, 0.f, 9).size(), 9u);
}

TEST(Reduction, LeavesAQuarterOfTheRaysToTheEdges) {
  Intrinsics k;
  for (const auto& [side, reduce] : {std::pair(100, 1), {200, 1}, {256, 2}, {512, 3}, {1024, 6}}) {
    k.width = k.height = side;
    EXPECT_EQ(reduction(k, 40000), reduce) << side;
  }
  k.width = k.height = 10;
  EXPECT_EQ(reduction(k, 1), 10);  // one ray is the least
}

}  // namespace
}  // namespace likeness
