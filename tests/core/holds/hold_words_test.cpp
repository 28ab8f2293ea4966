// Claims about what people are told: which side fails, why, and what to film against it.
#include "core/holds/hold_words.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

HoldingRange told_range() {
  HoldingRange range;
  range.yaw_low = {-20, "loose"}, range.yaw_high = {45, ""};
  range.pitch_low = {-10, "drift"}, range.pitch_high = {25, ""};
  range.actions = {{"jawOpen", 0.4f, "mouth"}, {"eyeBlink", 1, ""}, {"jawOpen+mouthSmile", 0.3f, "drift"}};
  return range;
}

TEST(HoldRemarks, AreOfSidesAndActionsThatFail) {
  const auto remarks = hold_remarks(told_range());
  ASSERT_EQ(remarks.size(), 3u);
  EXPECT_EQ(remarks[0].what,
            "From the person's right it holds up to 20 degrees: beyond that pieces hang loose.");
  EXPECT_EQ(remarks[0].film_again, film_again_side(HeadSide::right));
  EXPECT_EQ(remarks[1].what, "From below it holds up to 10 degrees: beyond that the skin changes colour.");
  EXPECT_EQ(remarks[2].what,
            "A wide open mouth holds up to 40 %: beyond that the open mouth is not dark inside.");
  EXPECT_EQ(remarks[2].film_again, "Open the mouth wide, slowly, twice.");
}

TEST(RangeWords, NameAllFourSides) {
  EXPECT_EQ(range_words(told_range()),
            "It holds from 20 degrees on the person's right to 45 on the left, 10 below to 25 above.");
}

TEST(RangeWords, ARangeBesideTheFrontIsToldAsItIs) {
  HoldingRange range = told_range();
  range.yaw_low.deg = 12, range.pitch_low.deg = 3;
  EXPECT_EQ(range_words(range),
            "It holds from 12 degrees on the person's left to 45 on the left, 3 above to 25 above.");
  EXPECT_EQ(hold_remarks(range)[0].what, "From the person's right it does not hold: pieces hang loose.");
}

TEST(SidesBeyond, TheFarthestOutsideFirst) {
  const HoldingRange range = told_range();
  EXPECT_TRUE(sides_beyond(range, 40, 20).empty());
  EXPECT_EQ(degrees_beyond(range, 40, 20), 0);
  EXPECT_EQ(sides_beyond(range, -24, -13), (std::vector{HeadSide::right, HeadSide::below}));
  EXPECT_DOUBLE_EQ(degrees_beyond(range, -24, -13), 5);
}

TEST(FilmAgainAction, IsItsOwnRequestOrAGeneralOne) {
  EXPECT_EQ(film_again_action("eyeBlink"), "Close the eyes for a full second, twice.");
  EXPECT_NE(film_again_action("jawLeft").find("jawLeft"), std::string::npos);
}

}  // namespace
}  // namespace likeness
