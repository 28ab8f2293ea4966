#include "core/base/number_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace likeness {
namespace {

double number_of(std::string_view text) {
  double value = -7;
  EXPECT_TRUE(take_number(text, value));
  EXPECT_TRUE(text.empty());
  return value;
}

TEST(TakeNumber, LeavesWhatFollows) {
  std::string_view text = "1.5e2 7";
  double value = 0;
  ASSERT_TRUE(take_number(text, value));
  EXPECT_EQ(value, 150);
  EXPECT_EQ(text, " 7");
  EXPECT_FALSE(take_number(text, value));
  EXPECT_EQ(text, " 7");
}

// The standard library says of both only that they are out of range, and gives no number.
TEST(TakeNumber, TooLargeIsInfiniteAndTooSmallIsZero) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const std::string zeros(400, '0');
  for (const std::string& large :
       std::vector<std::string>{"1e400", "12.5E+999", "1" + zeros, "0.0001e500", "1e99999999999999999999"})
    EXPECT_EQ(number_of(large), kInfinite) << large.substr(0, 12);
  EXPECT_EQ(number_of("-1e400"), -kInfinite);
  for (const std::string& small :
       std::vector<std::string>{"1e-400", "0." + zeros + "1", "1000e-500", "1e-99999999999999999999"})
    EXPECT_EQ(number_of(small), 0) << small.substr(0, 12);
  EXPECT_EQ(number_of("0e9999"), 0);
}

}  // namespace
}  // namespace likeness
