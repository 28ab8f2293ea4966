// Claims about plots.
#include "core/lab/study/plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace likeness {
namespace {

TEST(Plot, TicksAreRoundAndWithin) {
  EXPECT_EQ(plot_ticks(0, 10, 5, false), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(plot_ticks(1.5, 60, 8, true), (std::vector<double>{2, 5, 10, 20, 50}));
  EXPECT_EQ(plot_ticks(21, 24, 3, true), (std::vector<double>{21, 22, 23, 24}));  // within one decade's step
  EXPECT_TRUE(plot_ticks(1, 1, 5, false).empty());
  EXPECT_TRUE(plot_ticks(-1, 10, 5, true).empty());
}

// Pixels of a series' colour, and their mean place.
struct Seen {
  int count = 0;
  double x = 0, y = 0;
};
Seen look_for(const Image8& picture, int red, int green, int blue, int right) {
  Seen seen;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < right; ++x) {
      const std::uint8_t* p = picture.at(x, y);
      if (p[0] == red && p[1] == green && p[2] == blue) ++seen.count, seen.x += x, seen.y += y;
    }
  if (seen.count > 0) seen.x /= seen.count, seen.y /= seen.count;
  return seen;
}

TEST(Plot, HigherIsHigherAndLaterIsFurtherRight) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const Plot plot{"t", "s", "dB", true, {{"a", {{1, 20}}}, {"b", {{100, 30}, {none, 5}, {-1, 5}}}}};
  const Image8 picture = draw_plot(plot);
  ASSERT_EQ(picture.channels, 3);
  const Seen a = look_for(picture, 31, 119, 180, 740), b = look_for(picture, 255, 127, 14, 740);
  EXPECT_GT(a.count, 40);
  EXPECT_GT(b.count, 40);
  EXPECT_LT(b.count, 120);  // one mark: what is not finite has none
  EXPECT_LT(a.x + 300, b.x);
  EXPECT_GT(a.y, b.y + 200);
}

TEST(Plot, TwentySeriesAreAllNamedAndNoTwoLookAlike) {
  Plot plot{"t", "s", "dB", true, {}};
  for (int k = 0; k < 20; ++k) plot.series.push_back({"series", {{1.0 + k, 20.0 + k}}});
  const Image8 picture = draw_plot(plot);
  // The first and the eleventh share a colour, and the second time it is drawn hollow; both twice: mark and
  // name.
  const int full = 81, rim = 81 - 25;
  EXPECT_EQ(look_for(picture, 31, 119, 180, picture.width).count, 2 * (full + rim));
  EXPECT_EQ(look_for(picture, 23, 190, 207, picture.width).count,
            2 * (full + rim));  // the last is the twentieth
}

TEST(Plot, WithoutAnyPointIsEmptyAxes) {
  const Image8 picture = draw_plot({"t", "s", "dB", true, {{"a", {}}}});
  EXPECT_EQ(look_for(picture, 31, 119, 180, 740).count, 0);
}

}  // namespace
}  // namespace likeness
