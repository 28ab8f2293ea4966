// Claims about contact sheets: every picture is where it belongs, and places without one are white.
#include "core/lab/beyond/contact_sheet.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace likeness {
namespace {

constexpr int kWide = 5, kHigh = 3;

// A picture that is one level all over but for its first pixel, so that a picture that is shifted is noticed.
Image8 numbered(int number) {
  Image8 picture(kWide, kHigh, 3, std::uint8_t(10 * number));
  std::fill_n(picture.at(0, 0), 3, std::uint8_t(10 * number + 1));
  return picture;
}

// Whether that picture lies in the sheet's cell.
bool holds(const Image8& sheet, int column, int row, int number) {
  return crop(sheet, column * kWide, row * kHigh, kWide, kHigh).data == numbered(number).data;
}

ContactSheet sheet_of(int columns) {
  ContactSheet sheet;
  for (int i = 0; i < columns; ++i) {
    const Image8 above = numbered(2 * i + 1), below = numbered(2 * i + 2);
    sheet.add({&above, &below});
  }
  return sheet;
}

TEST(ContactSheet, PutsColumnsBesideEachOtherAndTheRestBelow) {
  const Image8 sheet = sheet_of(5).picture(3);
  ASSERT_EQ(sheet.width, 3 * kWide);
  ASSERT_EQ(sheet.height, 4 * kHigh);  // two bands of two pictures
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(holds(sheet, i % 3, i / 3 * 2, 2 * i + 1)) << i;
    EXPECT_TRUE(holds(sheet, i % 3, i / 3 * 2 + 1, 2 * i + 2)) << i;
  }
  const Image8 rest = crop(sheet, 2 * kWide, 2 * kHigh, kWide, 2 * kHigh);
  EXPECT_EQ(std::ranges::count(rest.data, 255), std::ptrdiff_t(rest.data.size()));
}

TEST(ContactSheet, OfFewColumnsIsNoWiderThanTheyAre) {
  const Image8 sheet = sheet_of(2).picture();
  EXPECT_EQ(sheet.width, 2 * kWide);
  EXPECT_EQ(sheet.height, 2 * kHigh);
  EXPECT_TRUE(holds(sheet, 1, 1, 4));
}

TEST(ContactSheet, OfNothingIsEmpty) { EXPECT_TRUE(ContactSheet().picture().empty()); }

}  // namespace
}  // namespace likeness
