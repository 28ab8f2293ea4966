// Claims about what an avatar is asked for: the head can do all of it, on both sides.
#include "core/holds/asked.h"

#include <gtest/gtest.h>

#include <set>

#include "core/head/builtin_head.h"

namespace likeness {
namespace {

const HeadModel& asked_head() {
  static const HeadModel model = make_builtin_head();
  return model;
}

TEST(AskedViews, BeginAtTheFrontAndGoAsFarToEitherSide) {
  const auto& views = asked_views();
  ASSERT_GT(views.size(), 2u);
  EXPECT_EQ(views.front().yaw, 0);
  EXPECT_EQ(views.front().pitch, 0);
  std::set<std::pair<double, double>> all;
  for (const AskedView& view : views) all.emplace(view.yaw, view.pitch);
  EXPECT_EQ(all.size(), views.size()) << "one is asked for twice";
  for (const AskedView& view : views) EXPECT_TRUE(all.contains({-view.yaw, -view.pitch})) << view.yaw;
}

TEST(AskedActions, AreActionsOfTheBuiltInHead) {
  std::set<std::pair<std::string, float>> all;
  for (const AskedAction& asked : asked_actions()) {
    ASSERT_FALSE(asked.actions.empty());
    std::string joined;
    for (const std::string& action : asked.actions) {
      EXPECT_FALSE(sides_of(asked_head(), action).empty()) << action;
      joined += (joined.empty() ? "" : "+") + action;
    }
    EXPECT_EQ(asked.name, joined);
    EXPECT_GT(asked.amount, 0);
    EXPECT_LE(asked.amount, 1);
    all.emplace(asked.name, asked.amount);
  }
  EXPECT_EQ(all.size(), asked_actions().size()) << "one is asked for twice";
}

TEST(SidesOf, AreBothOrTheOnlyOne) {
  const auto smile = sides_of(asked_head(), "mouthSmile");
  ASSERT_EQ(smile.size(), 2u);
  EXPECT_EQ(smile[0]->name, "mouthSmile_L");
  EXPECT_EQ(smile[1]->name, "mouthSmile_R");
  const auto jaw = sides_of(asked_head(), "jawOpen");
  ASSERT_EQ(jaw.size(), 1u);
  EXPECT_EQ(jaw[0]->name, "jawOpen");
  EXPECT_TRUE(sides_of(asked_head(), "wagTheTail").empty());
}

TEST(PerformAsked, AddsBothSidesOfEveryActionToWhatIsThere) {
  const HeadModel& model = asked_head();
  Articulation before = neutral_articulation(model);
  add_action(before, *find_action(model, "browInnerUp_L"), 0.3f);
  Articulation performed = before, expected = before;
  perform_asked(model, {"jawOpen+mouthSmile", {"jawOpen", "mouthSmile"}, 0.5f}, performed);
  for (const char* name : {"jawOpen", "mouthSmile_L", "mouthSmile_R"})
    add_action(expected, *find_action(model, name), 0.5f);
  EXPECT_TRUE(performed.expression.isApprox(expected.expression));
  EXPECT_TRUE(performed.jaw.isApprox(expected.jaw));
  EXPECT_GT((performed.expression - before.expression).norm(), 0.5f);
  EXPECT_GT((performed.jaw - before.jaw).norm(), 0.05f);
}

}  // namespace
}  // namespace likeness
