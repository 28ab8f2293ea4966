// Claims about what of a film goes beyond what holds: views on either axis, the actions that were tried, and
// nothing of a film that stays within.
#include "core/direct/beyond_holds.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "core/direct/direct_avatar.h"
#include "core/direct/set_values.h"
#include "tests/core/export/tiny_project.h"

namespace likeness::test {
namespace {

HoldingRange some_range() {
  HoldingRange range;
  range.yaw_low = {-20, "drift"}, range.yaw_high = {30, "loose"};
  range.pitch_low = {-25, ""}, range.pitch_high = {25, ""};
  range.actions = {{"jawOpen", 0.4f, "mouth"}, {"mouthSmile", 1, ""}};
  return range;
}

BeyondHolds of_performance(const std::map<std::string, float>& values) {
  const OpenedAvatar opened = tiny_opened();
  Performance performance;
  performance.duration_s = 0.04, performance.frames_per_second = 25;
  for (const auto& [channel, value] : values) set_value(performance, channel, value, {});
  const auto film = direct_film(opened, performance);
  EXPECT_TRUE(film.ok());
  return beyond_holds(some_range(), opened.avatar, opened.model, *film);
}

TEST(BeyondHolds, AFilmWithinIsEmpty) {
  EXPECT_TRUE(of_performance({}).empty());
  EXPECT_TRUE(of_performance({{"camera yaw", 28}, {"action jawOpen", 0.4f}}).empty());
  EXPECT_TRUE(beyond_remarks({}, some_range()).empty());
}

TEST(BeyondHolds, OrbitAndHeadTurnCountAlike) {
  const BeyondHolds left = of_performance({{"camera yaw", 45}});
  EXPECT_GT(left.frames, 0);
  EXPECT_NEAR(left.view_deg, 15, 0.5);
  EXPECT_EQ(left.sides, std::vector{HeadSide::left});
  const BeyondHolds right = of_performance({{"head yaw", 35}});  // shows its right side
  EXPECT_NEAR(right.view_deg, 15, 3);
  EXPECT_EQ(right.sides, std::vector{HeadSide::right});
  EXPECT_TRUE(right.actions.empty());
}

TEST(BeyondHolds, AnActionIsNamedWithItsMostAndWhatToFilm) {
  const BeyondHolds beyond =
      of_performance({{"action jawOpen", 0.9f}, {"action mouthSmile_L", 1}, {"action mouthSmile_R", 1}});
  EXPECT_TRUE(beyond.sides.empty());
  ASSERT_EQ(beyond.actions.size(), 1u);
  EXPECT_EQ(beyond.actions[0].first, "jawOpen");
  EXPECT_NEAR(beyond.actions[0].second, 0.9f, 0.03f);
  const auto remarks = beyond_remarks(beyond, some_range());
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_EQ(remarks[0].what, "jawOpen goes to 90 %, the avatar holds it up to 40 %.");
  EXPECT_EQ(remarks[0].film_again, "Open the mouth wide, slowly, twice.");
}

}  // namespace
}  // namespace likeness::test
