// Claims about what is wrong with drawn pictures: what counts, what does not, and what a mask leaves out.
#include "core/holds/picture_faults.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace likeness {
namespace {

constexpr int kPictureSide = 100;

Image clear() { return {kPictureSide, kPictureSide, 1}; }

void fill_square(Image& alpha, int left, int top, int side, float value) {
  for (int y = top; y < top + side; ++y)
    for (int x = left; x < left + side; ++x) std::fill_n(alpha.at(x, y), std::size_t(alpha.channels), value);
}

Image8 square_mask(int left, int top, int side) {
  Image8 mask(kPictureSide, kPictureSide, 1);
  for (int y = top; y < top + side; ++y)
    for (int x = left; x < left + side; ++x) *mask.at(x, y) = 255;
  return mask;
}

TEST(LooseShare, IsOfThePiecesThatDoNotTouchTheLargest) {
  Image alpha = clear();
  fill_square(alpha, 20, 20, 30, 1);  // 900 pixels
  EXPECT_EQ(loose_share(alpha), 0);
  fill_square(alpha, 50, 50, 10, 1);  // touches at a corner
  EXPECT_EQ(loose_share(alpha), 0);
  fill_square(alpha, 80, 80, 10, 1);
  EXPECT_DOUBLE_EQ(loose_share(alpha), 100.0 / 1100);
  fill_square(alpha, 5, 5, 5, 0.4f);  // faint: no piece
  EXPECT_DOUBLE_EQ(loose_share(alpha), 100.0 / 1100);
  EXPECT_EQ(loose_share(clear()), 0);
}

TEST(ShreddedShare, CountsHolesAndVeilsInsideButNotASoftOutline) {
  Image alpha = clear();
  fill_square(alpha, 20, 20, 60, 1);
  EXPECT_EQ(shredded_share(alpha), 0);
  Image soft = clear();
  fill_square(soft, 19, 19, 62, 0.5f), fill_square(soft, 20, 20, 60, 1);
  EXPECT_EQ(shredded_share(soft), 0);
  Image hole = alpha, veil = alpha;
  fill_square(hole, 48, 48, 4, 0), fill_square(veil, 48, 48, 4, 0.6f);
  EXPECT_GT(shredded_share(hole), 0.003);
  EXPECT_DOUBLE_EQ(shredded_share(hole), shredded_share(veil));
}

TEST(ShreddedShare, APersonCutByThePicturesEdgeIsWholeThere) {
  Image alpha = clear();
  for (int y = 40; y < kPictureSide; ++y)
    for (int x = 20; x < 80; ++x) *alpha.at(x, y) = 1;
  Image torn = alpha;
  EXPECT_EQ(shredded_share(alpha), 0);
  for (int x = 20; x < 80; ++x) *torn.at(x, kPictureSide - 1) = 0.3f;  // the lowest row, seen through
  EXPECT_GT(shredded_share(torn), 0.01);
}

TEST(MissingShare, IsTheLightThatComesThroughTheMaskButForItsRim) {
  const Image8 mask = square_mask(20, 20, 40);
  Image alpha = clear();
  fill_square(alpha, 20, 20, 40, 1);
  EXPECT_EQ(missing_share(alpha, mask, 2), 0);
  Image halved = alpha;
  fill_square(halved, 20, 20, 40, 0.5f);
  EXPECT_DOUBLE_EQ(missing_share(halved, mask, 2), 0.5);
  Image rimless = clear();
  fill_square(rimless, 22, 22, 36, 1);
  EXPECT_EQ(missing_share(rimless, mask, 2.5), 0);
  EXPECT_GT(missing_share(rimless, mask, 0), 0.1);
}

TEST(OutsideShare, IsWhatLiesBeyondTheHairsReachAboveTheLine) {
  const Image8 mask = square_mask(30, 30, 20);
  const Above above{{0, 50}, {0, -1}};
  Image alpha = clear();
  fill_square(alpha, 25, 25, 25, 1);  // hair to the left and above by 5
  const double reach = reach_px(alpha, mask, above);
  EXPECT_GT(reach, 4);
  EXPECT_LT(reach, 8);
  EXPECT_EQ(outside_share(alpha, mask, above, 8), 0);
  fill_square(alpha, 80, 40, 10, 1);  // something beside, above the line
  EXPECT_DOUBLE_EQ(outside_share(alpha, mask, above, 8), 100.0 / 400);
  fill_square(alpha, 80, 60, 10, 1);  // a shoulder
  EXPECT_DOUBLE_EQ(outside_share(alpha, mask, above, 8), 100.0 / 400);
}

TEST(SpeckShareWithin, ALonePixelIsASpeckAnEdgeIsNot) {
  Image rgb(kPictureSide, kPictureSide, 3, 0.5f);
  const Image8 mask = square_mask(20, 20, 50);
  EXPECT_EQ(speck_share_within(rgb, mask), 0);
  rgb.at(30, 30)[2] = 0.5f + 60 / 255.f;
  EXPECT_DOUBLE_EQ(speck_share_within(rgb, mask), 1.0 / 2500);
  rgb.at(90, 90)[0] = 1;  // outside the mask
  EXPECT_DOUBLE_EQ(speck_share_within(rgb, mask), 1.0 / 2500);
  for (int y = 0; y < kPictureSide; ++y)
    for (int x = 50; x < kPictureSide; ++x) std::fill_n(rgb.at(x, y), 3, 1.f);
  EXPECT_DOUBLE_EQ(speck_share_within(rgb, mask), 1.0 / 2500);
  rgb.at(40, 40)[1] = 0.5f + 40 / 255.f;  // not far enough
  EXPECT_DOUBLE_EQ(speck_share_within(rgb, mask), 1.0 / 2500);
}

TEST(ChangeWithin, IsOfTheMaskAloneAndEitherWay) {
  const Image a(kPictureSide, kPictureSide, 3, 0.5f);
  Image b = a;
  const Image8 mask = square_mask(10, 10, 10);
  for (int x = 10; x < 20; ++x) b.at(x, 10)[0] = 0.8f, b.at(x, 11)[1] = 0.2f;
  EXPECT_NEAR(change_within(a, b, mask), 2 * 10 * 0.3 / 300, 1e-6);
  b.at(50, 50)[0] = 0;
  EXPECT_NEAR(change_within(a, b, mask), 2 * 10 * 0.3 / 300, 1e-6);
  EXPECT_EQ(change_within(a, b, Image8(kPictureSide, kPictureSide, 1)), 0);
  EXPECT_NEAR(brightness_within(a, mask), 0.5, 1e-6);
}

}  // namespace
}  // namespace likeness
