// Claims about pictures rendered at a part of their size.
#include "core/render/pixel_bands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

namespace likeness {
namespace {

TEST(EdgeCells, LieAcrossAStep) {
  Image picture(6, 3, 4);
  for (int y = 0; y < 3; ++y)
    for (int x = 3; x < 6; ++x) picture.at(x, y)[2] = 0.5f;
  const auto cells = edge_cells(picture, 0.4f, 100);
  EXPECT_EQ(cells, (std::vector<Eigen::Vector2i>{{2, -1}, {2, 0}, {2, 1}, {2, 2}}));
  EXPECT_TRUE(edge_cells(picture, 0.5f, 100).empty());
}

TEST(EdgeCells, KeepTheLargestStepsWhenThereAreTooMany) {
  Image picture(9, 1, 1);
  for (int x = 0; x < 9; ++x) picture.at(x, 0)[0] = float(x * x) / 64;  // steps grow with x
  EXPECT_EQ(edge_cells(picture, 0.f, 2), (std::vector<Eigen::Vector2i>{{7, -1}, {7, 0}}));
  EXPECT_EQ(edge_cells(picture, 0.f, 1).size(), 1u);  // both have the same step
  EXPECT_TRUE(edge_cells(picture, 0.f, 0).empty());
  EXPECT_EQ(edge_cells(picture, 0.f, 99).size(), 16u);
}

// An outline steps from nothing to opaque all along.
TEST(EdgeCells, EqualStepsAreTakenAllOverThePicture) {
  Image picture(4, 100, 1);
  for (int y = 0; y < 100; ++y) picture.at(2, y)[0] = picture.at(3, y)[0] = 1;
  const auto cells = edge_cells(picture, 0.5f, 60);
  ASSERT_EQ(cells.size(), 60u);
  const auto above = std::ranges::count_if(cells, [](const Eigen::Vector2i& p) { return p.y() < 50; });
  EXPECT_NEAR(double(above), 30, 8);
}

// Whatever the sizes, every pixel of the whole picture lies in one cell, between the centres of that cell's
// corners.
TEST(EdgeBand, CellsPartitionThePixels) {
  for (const auto& [width, height, reduce] : {std::tuple(12, 9, 3),
                                              {16, 16, 2},
                                              {47, 48, 2},
                                              {512, 31, 3},
                                              {10, 7, 4},
                                              {5, 5, 5},
                                              {3, 3, 2},
                                              {9, 1, 2}}) {
    Intrinsics k;
    k.width = width, k.height = height, k.fx = k.fy = 100, k.cx = 0.5 * width, k.cy = 0.5 * height;
    const Intrinsics fewer = reduced(k, reduce);
    std::vector<Eigen::Vector2i> all;
    for (int y = -1; y < fewer.height; ++y)
      for (int x = -1; x < fewer.width; ++x) all.emplace_back(x, y);
    std::vector<std::uint32_t> places = edge_band(k, fewer, all).place;
    std::ranges::sort(places);
    ASSERT_EQ(places.size(), std::size_t(width) * std::size_t(height));
    for (std::size_t i = 0; i < places.size(); ++i) EXPECT_EQ(places[i], i);
    const auto cell_of = [](std::uint32_t pixel, int from, int to) {
      return int(std::floor((pixel + 0.5) * from / to - 0.5 + 1e-9));
    };
    const auto columns = std::uint32_t(width);
    for (const Eigen::Vector2i& cell : all)
      for (const std::uint32_t place : edge_band(k, fewer, {&cell, 1}).place) {
        EXPECT_EQ(cell_of(place % columns, fewer.width, width), cell.x()) << place;
        EXPECT_EQ(cell_of(place / columns, fewer.height, height), cell.y()) << place;
      }
  }
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
