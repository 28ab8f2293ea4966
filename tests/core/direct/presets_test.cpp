// Claims about presets: within what was seen, and instead of the expression that was there.
#include "core/direct/presets.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/direct/edit_keys.h"
#include "core/direct/seen_limits.h"
#include "tests/core/export/tiny_project.h"

namespace likeness::test {
namespace {

TEST(Presets, StayWithinTheSeenRangeAndSayHowFarTheyGo) {
  const auto seen = seen_from_rest(filmed_avatar(), tiny_head());
  const auto list = presets(tiny_head(), seen);
  ASSERT_EQ(list.size(), 9u);
  EXPECT_TRUE(list[0].actions.empty());
  EXPECT_FLOAT_EQ(list[0].seen, 1);
  for (const Preset& preset : list)
    for (const auto& [name, amount] : preset.actions) {
      const auto range = std::ranges::find(seen, name, &SeenAction::name);
      ASSERT_NE(range, seen.end());
      EXPECT_GE(amount, 0);
      EXPECT_LE(amount, range->high) << preset.name << " " << name;
    }
  const Preset& smile = list[1];
  EXPECT_GT(smile.seen, 0.05f);  // only the left corner was seen, a little
  EXPECT_LT(smile.seen, 0.2f);
  std::vector<SeenAction> everything = seen;
  for (SeenAction& action : everything) action.high = 1;
  for (const Preset& preset : presets(tiny_head(), everything))
    EXPECT_FLOAT_EQ(preset.seen, 1) << preset.name;
}

TEST(Presets, ReplaceThePreviousExpression) {
  Performance performance;
  set_key(performance, "action browDown_L", {0, 1});
  set_key(performance, "head yaw", {0, 10});
  apply_preset(performance, {"A", {{"jawOpen", 0.4f}}, 1}, {.time_s = 2, .record = true});
  EXPECT_FLOAT_EQ(value_at(performance, "action browDown_L", 2), 0);
  EXPECT_FLOAT_EQ(value_at(performance, "action browDown_L", 0), 1);
  EXPECT_FLOAT_EQ(value_at(performance, "action jawOpen", 2), 0.4f);
  EXPECT_FLOAT_EQ(value_at(performance, "action jawOpen", 0), 0);
  EXPECT_EQ(performance.channels.at("head yaw").size(), 1u);
}

TEST(Presets, AreConstantUnlessTheyAreRecorded) {
  Performance performance;
  apply_preset(performance, {"A", {{"jawOpen", 0.4f}}, 1}, {.time_s = 2});
  EXPECT_FLOAT_EQ(value_at(performance, "action jawOpen", 0), 0.4f);
  apply_preset(performance, {"neutral", {}, 1}, {.time_s = 1});
  EXPECT_TRUE(performance.channels.empty());
}

}  // namespace
}  // namespace likeness::test
