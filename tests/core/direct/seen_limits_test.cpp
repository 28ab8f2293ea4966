// Claims about seen limits: counted from rest, and from the typical pose.
#include "core/direct/seen_limits.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/core/export/tiny_project.h"

namespace likeness::test {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180;

TEST(SeenLimits, CountFromRestAndFromTheTypicalPose) {
  Avatar avatar = filmed_avatar();
  add_action(avatar.neutral, *find_action(tiny_head(), "jawOpen"), 0.1f);
  SeenViews views;
  views.low = {-10 * kRadPerDegree, -5 * kRadPerDegree, -2 * kRadPerDegree},
  views.high = {30 * kRadPerDegree, 8 * kRadPerDegree, 4 * kRadPerDegree};
  const auto limits = seen_limits(avatar, tiny_head(), views);
  EXPECT_NEAR(limits.at("action jawOpen").high, 0.4f, 0.01f);
  EXPECT_NEAR(limits.at("action browDown_L").high, 0, 1e-6f);
  EXPECT_NEAR(limits.at("camera yaw").high, 30, 1e-3);
  EXPECT_NEAR(limits.at("head yaw").low, -30, 1e-3);  // turning right shows what a camera on the left sees
  EXPECT_NEAR(limits.at("head pitch").high, 8, 1e-3);
}

}  // namespace
}  // namespace likeness::test
