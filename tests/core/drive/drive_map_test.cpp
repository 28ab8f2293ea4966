// Claims about the parts that driving a clip and a stream share.
#include "core/drive/drive_map.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

TEST(SoftClamp, IsTheIdentityInsideAndBoundedOutside) {
  EXPECT_EQ(soft_clamp(0.3f, 0, 1, 0.1f), 0.3f);
  float last = -10;
  for (float x = -3; x < 4; x += 0.01f) {
    const float y = soft_clamp(x, 0, 1, 0.1f);
    EXPECT_GE(y, last);
    EXPECT_GE(y, -0.1001f);
    EXPECT_LE(y, 1.1001f);
    last = y;
  }
}

}  // namespace
}  // namespace likeness
