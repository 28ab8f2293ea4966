// Claims about the order of names.
#include "core/base/natural_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace likeness {
namespace {

TEST(NaturalOrder, NumbersInNamesCountAsNumbers) {
  const std::vector<std::string> wanted{"",
                                        "1.jpg",
                                        "1a.jpg",
                                        "2.jpg",
                                        "10.jpg",
                                        "a1b2",
                                        "a1b10",
                                        "a99999999999999999999",
                                        "a100000000000000000000",
                                        "IMG_9.JPG",
                                        "img_10.jpg",
                                        "IMG_0011.JPG",
                                        "m\xfcller2",
                                        "m\xfcller10"};
  std::vector<std::string> names(wanted.rbegin(), wanted.rend());
  std::ranges::sort(names, naturally_before);
  EXPECT_EQ(names, wanted);
}

TEST(NaturalOrder, TellsAnyTwoNamesApart) {
  const std::vector<std::string> names{"a1", "A1", "a01", "a001", "a1 ", "a"};
  for (const auto& a : names)
    for (const auto& b : names)
      EXPECT_EQ(naturally_before(a, b) || naturally_before(b, a), a != b) << a << " " << b;
}

}  // namespace
}  // namespace likeness
