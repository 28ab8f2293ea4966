// Claims about what the capture never showed: views by the nearest one, actions by their range.
#include "core/direct/beyond_seen.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/direct/set_values.h"
#include "tests/core/export/tiny_project.h"

namespace likeness::test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

TEST(BeyondSeen, HeadTurnAndCameraOrbitCountAlike) {
  const OpenedAvatar opened = tiny_opened();
  const DirectedAvatar directed = direct_avatar(opened.avatar, opened.model);
  const ViewAngle typical = view_angle(opened.avatar.cam_from_world * opened.avatar.world_from_head);
  const SeenViews views{typical, typical, {typical}};
  Performance performance;
  const auto view = [&] { return beyond_seen(directed, views, {}, performance, 0).view; };
  EXPECT_NEAR(view(), 0, 1e-6);
  set_value(performance, "camera yaw", 25, {});
  EXPECT_NEAR(view(), 25 * kDegree, 0.5 * kDegree);
  set_value(performance, "head yaw", 25, {});  // turned after the camera it is seen as it was
  EXPECT_LT(view(), 3 * kDegree);
  EXPECT_EQ(view_doubt(3 * kDegree), 0);
  EXPECT_EQ(view_doubt(60 * kDegree), 1);
  EXPECT_GT(view_doubt(20 * kDegree), view_doubt(10 * kDegree));
}

TEST(BeyondSeen, NamesActionsBeyondTheirSeenRange) {
  const OpenedAvatar opened = tiny_opened();
  const DirectedAvatar directed = direct_avatar(opened.avatar, opened.model);
  const std::map<std::string, ValueRange> limits{{"action jawOpen", {0, 0.4f}}};
  Performance performance;
  set_value(performance, "action jawOpen", 0.5f, {});
  EXPECT_TRUE(beyond_seen(directed, {}, limits, performance, 0).actions.empty());
  set_value(performance, "action jawOpen", 0.8f, {});
  EXPECT_EQ(beyond_seen(directed, {}, limits, performance, 0).actions, std::vector<std::string>{"jawOpen"});
}

TEST(BeyondSeen, IsCountedFromWhatHoldsWhereThatIsKnown) {
  OpenedAvatar opened = tiny_opened();
  opened.avatar.holds.emplace();
  opened.avatar.holds->yaw_low = {-20, "drift"}, opened.avatar.holds->yaw_high = {20, "drift"};
  opened.avatar.holds->pitch_low.deg = -25, opened.avatar.holds->pitch_high.deg = 25;
  const DirectedAvatar directed = direct_avatar(opened.avatar, opened.model);
  const ViewAngle typical = view_angle(opened.avatar.cam_from_world * opened.avatar.world_from_head);
  const SeenViews views{typical, typical, {typical}};  // none but the typical one was seen
  Performance performance;
  set_value(performance, "camera yaw", 18, {});
  BeyondSeen beyond = beyond_seen(directed, views, {}, performance, 0);
  EXPECT_TRUE(beyond.checked);
  EXPECT_EQ(beyond.view, 0);
  EXPECT_TRUE(beyond.sides.empty());
  set_value(performance, "camera yaw", 32, {});
  beyond = beyond_seen(directed, {}, {}, performance, 0);  // nor need any have been
  EXPECT_NEAR(beyond.view, 12 * kDegree, 0.5 * kDegree);
  EXPECT_EQ(beyond.sides, std::vector{HeadSide::left});
}

}  // namespace
}  // namespace likeness::test
