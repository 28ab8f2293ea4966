// Claims about what is measured in pictures of an avatar: what counts, what does not, and what nothing makes.
#include "core/lab/beyond/measures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace likeness {
namespace {

constexpr int kSide = 32;

Image8 plain(std::uint8_t level) { return {kSide, kSide, 3, level}; }
Image8 no_mask() { return {kSide, kSide, 1}; }
Image8 whole_mask() { return {kSide, kSide, 1, 255}; }

// A square of the picture, in all channels.
void paint(Image8& picture, int left, int top, int side, std::uint8_t level) {
  for (int y = top; y < top + side; ++y)
    for (int x = left; x < left + side; ++x)
      std::fill_n(picture.at(x, y), std::size_t(picture.channels), level);
}

TEST(SpeckShare, ALoneWrongPixelIsASpeckAndAWrongAreaIsNot) {
  const Image8 truth = plain(120);
  Image8 rendered = truth;
  paint(rendered, 5, 6, 1, 220), paint(rendered, 20, 9, 1, 10);
  EXPECT_DOUBLE_EQ(speck_share(truth, rendered, whole_mask()), 2.0 / (kSide * kSide));
  // Most of the neighbours are as wrong: no speck. That does not hold of a square's corners, where they are
  // few.
  Image8 patch = truth;
  paint(patch, 8, 8, 12, 220);
  Image8 within = no_mask();
  paint(within, 10, 10, 8, 255);
  EXPECT_EQ(speck_share(truth, patch, within), 0);
}

TEST(SpeckShare, APixelAsInTheTruthIsNoneHoweverFarFromItsNeighbours) {
  Image8 truth = plain(120);
  paint(truth, 5, 6, 1, 250);  // a catchlight
  EXPECT_EQ(speck_share(truth, truth, whole_mask()), 0);
  // It is one where the truth has none.
  EXPECT_GT(speck_share(plain(120), truth, whole_mask()), 0);
}

TEST(SpeckShare, OneChannelIsEnoughAndTheMaskAloneCounts) {
  const Image8 truth = plain(120);
  Image8 rendered = truth;
  rendered.at(8, 8)[2] = 120 + 49;   // blue alone
  rendered.at(24, 8)[2] = 120 + 48;  // not yet
  Image8 mask = no_mask();
  paint(mask, 4, 4, 10, 255);
  EXPECT_DOUBLE_EQ(speck_share(truth, rendered, mask), 1.0 / 100);
  EXPECT_DOUBLE_EQ(speck_share(truth, rendered, whole_mask()), 1.0 / (kSide * kSide));
  Image8 beside = no_mask();
  paint(beside, 14, 14, 10, 255);
  EXPECT_EQ(speck_share(truth, rendered, beside), 0);
}

TEST(MeanColour, IsOfTheMaskAlone) {
  Image8 picture = plain(10);
  Image8 mask = no_mask();
  paint(mask, 3, 3, 2, 255);
  paint(picture, 3, 3, 2, 100);
  picture.at(3, 3)[0] = 200, picture.at(4, 4)[2] = 0;
  EXPECT_TRUE(mean_colour(picture, mask).isApprox(Vec3d(125, 100, 75)));
}

TEST(MeanChange, CountsEveryChannelEitherWay) {
  const Image8 a = plain(100);
  Image8 b = a;
  Image8 mask = no_mask();
  paint(mask, 3, 3, 2, 255);
  b.at(3, 3)[0] = 106, b.at(4, 3)[1] = 94;
  b.at(10, 10)[0] = 0;  // outside
  EXPECT_DOUBLE_EQ(mean_change(a, b, mask), 1);
  EXPECT_DOUBLE_EQ(mean_change(b, a, mask), 1);
  EXPECT_EQ(mean_change(a, a, mask), 0);
}

TEST(MaskIou, IsTheSharedAreaOfTheWhole) {
  Image8 a = no_mask(), b = no_mask();
  paint(a, 0, 0, 10, 255), paint(b, 5, 0, 10, 255);
  EXPECT_DOUBLE_EQ(mask_iou(a, b), 50.0 / 150);
  EXPECT_DOUBLE_EQ(mask_iou(a, a), 1);
  EXPECT_DOUBLE_EQ(mask_iou(a, no_mask()), 0);
}

TEST(BeyondMeasures, OfNothingAreNoNumberAndTwoEmptyMasksAgree) {
  const Image8 picture = plain(100);
  EXPECT_TRUE(std::isnan(speck_share(picture, picture, no_mask())));
  EXPECT_TRUE(mean_colour(picture, no_mask()).array().isNaN().all());
  EXPECT_TRUE(std::isnan(mean_change(picture, picture, no_mask())));
  EXPECT_EQ(mask_iou(no_mask(), no_mask()), 1);
}

}  // namespace
}  // namespace likeness
