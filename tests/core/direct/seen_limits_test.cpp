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

TEST(SeenLimits, AreThoseThatHoldWhereTheyAreKnown) {
  Avatar avatar = filmed_avatar();
  SeenViews views;
  views.low = {-10 * kRadPerDegree, -5 * kRadPerDegree, -2 * kRadPerDegree},
  views.high = {30 * kRadPerDegree, 8 * kRadPerDegree, 4 * kRadPerDegree};
  EXPECT_FALSE(limits_hold(avatar, "camera yaw"));
  avatar.holds.emplace();
  avatar.holds->yaw_low.deg = -18, avatar.holds->yaw_high.deg = 22;
  avatar.holds->pitch_low.deg = -12, avatar.holds->pitch_high.deg = 7;
  avatar.holds->actions = {{"jawOpen", 0.8f, "mouth"}, {"mouthSmile", 0.1f, "drift"}};
  const auto limits = seen_limits(avatar, tiny_head(), views);
  EXPECT_NEAR(limits.at("camera yaw").low, -18, 1e-3);
  EXPECT_NEAR(limits.at("camera yaw").high, 22, 1e-3);
  EXPECT_NEAR(limits.at("head yaw").low, -22, 1e-3);
  EXPECT_NEAR(limits.at("camera pitch").low, -12, 1e-3);
  EXPECT_NEAR(limits.at("head roll").high, 4, 1e-3);  // shows nothing new, and is not tried
  EXPECT_FLOAT_EQ(limits.at("action jawOpen").high, 0.8f);
  EXPECT_FLOAT_EQ(limits.at("action mouthSmile_L").high, 0.1f);
  EXPECT_FLOAT_EQ(limits.at("action mouthSmile_R").high, 0.1f);
  EXPECT_TRUE(limits_hold(avatar, "camera yaw"));
  EXPECT_TRUE(limits_hold(avatar, "action mouthSmile_L"));
  EXPECT_FALSE(limits_hold(avatar, "action browDown_L"));
  EXPECT_FALSE(limits_hold(avatar, "head roll"));
}

}  // namespace
}  // namespace likeness::test
