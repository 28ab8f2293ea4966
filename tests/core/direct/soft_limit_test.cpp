// Claims about limits that resist: a drag from inside stops, the next one goes on, a key goes on at once.
#include "core/direct/soft_limit.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

constexpr ValueRange kHeld{-20, 30};

TEST(SoftlyLimited, ADragFromInsideStopsAtTheLimit) {
  EXPECT_EQ(softly_limited(0, 25, kHeld, false), 25);
  EXPECT_EQ(softly_limited(0, 35, kHeld, false), 30);
  EXPECT_EQ(softly_limited(0, -50, kHeld, false), -20);
}

TEST(SoftlyLimited, ASecondDragGoesOnFromThere) {
  EXPECT_EQ(softly_limited(30, 35, kHeld, false), 35);
  EXPECT_EQ(softly_limited(-20, -28, kHeld, false), -28);
  EXPECT_EQ(softly_limited(40, 44, kHeld, false), 44);
  // The other side still resists.
  EXPECT_EQ(softly_limited(40, -44, kHeld, false), -20);
}

TEST(SoftlyLimited, WhoeverInsistsIsNotStopped) { EXPECT_EQ(softly_limited(0, 35, kHeld, true), 35); }

TEST(SoftlyLimited, AnEmptyRangeLimitsNothing) { EXPECT_EQ(softly_limited(0, 35, {0, 0}, false), 35); }

}  // namespace
}  // namespace likeness
