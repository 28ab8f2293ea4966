// Claims about pieces in the air, on grids of a block and what lies beside it.
#include "core/train/loose_cells.h"

#include <gtest/gtest.h>

#include <array>

namespace likeness {
namespace {

constexpr int kGrid = 40, kThick = 60, kThin = 10;

std::size_t cell_at(int x, int y, int z) { return std::size_t((z * kGrid + y) * kGrid + x); }

void fill(FieldPart& part, std::array<int, 3> from, int side, int opacity) {
  for (int z = from[2]; z < from[2] + side; ++z)
    for (int y = from[1]; y < from[1] + side; ++y)
      for (int x = from[0]; x < from[0] + side; ++x) {
        set_occupied(part.occupancy, x, y, z, true);
        part.opacity[cell_at(x, y, z)] = std::uint8_t(opacity);
      }
}

// A solid block of 10 cells a side from (10, 10, 10) on.
FieldPart block() {
  FieldPart part;
  part.occupancy = make_occupancy(kGrid, false);
  part.opacity.assign(std::size_t(kGrid) * kGrid * kGrid, 0);
  fill(part, {10, 10, 10}, 10, kThick);
  return part;
}

TEST(LooseCells, APieceInTheAirIsDroppedAndWhatTouchesTheRestStays) {
  FieldPart part = block();
  fill(part, {21, 12, 12}, 3, kThick);  // a cell beside the block: joined
  fill(part, {25, 12, 12}, 2, kThick);  // a cell beside that: joined, too
  fill(part, {12, 12, 32}, 3, kThick);  // far
  EXPECT_EQ(drop_loose_cells(part, 40), 27u);
  EXPECT_TRUE(part.occupancy.occupied(10, 10, 10));
  EXPECT_TRUE(part.occupancy.occupied(22, 13, 13));
  EXPECT_TRUE(part.occupancy.occupied(26, 13, 13));
  EXPECT_FALSE(part.occupancy.occupied(13, 13, 33));
  EXPECT_EQ(part.opacity[cell_at(13, 13, 33)], 0);
}

TEST(LooseCells, HazeStaysAboutWhatIsSolidAlone) {
  FieldPart part = block();
  fill(part, {12, 12, 20}, 8, kThin);
  EXPECT_EQ(drop_loose_cells(part, 40), 8u * 8 * 6);
  EXPECT_TRUE(part.occupancy.occupied(15, 15, 21));
  EXPECT_FALSE(part.occupancy.occupied(15, 15, 22));
}

TEST(LooseCells, AnotherPieceOfTheSameKindOfSizeStays) {
  FieldPart part = block();
  fill(part, {12, 12, 30}, 5, kThick);
  EXPECT_EQ(drop_loose_cells(part, 40), 0u);
}

TEST(LooseCells, AYoungFieldThatIsHazeAllOverIsLeftAlone) {
  FieldPart part = block();
  fill(part, {0, 0, 22}, 18, 30);
  EXPECT_EQ(drop_loose_cells(part, 40), 0u);
}

TEST(LooseCells, NothingIsDroppedBeforeAnythingIsKnownOrSolid) {
  FieldPart part = block();
  EXPECT_EQ(drop_loose_cells(part, kThick + 1), 0u);
  part.opacity.clear();
  EXPECT_EQ(drop_loose_cells(part, 40), 0u);
  EXPECT_TRUE(part.occupancy.occupied(10, 10, 10));
}

}  // namespace
}  // namespace likeness
