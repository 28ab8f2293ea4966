// Claims about expressions that a clip never shows: they are those of the model that it shows least, farther
// than it shows them, and nothing that it shows wholly.
#include "core/train/unseen_expressions.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/train/filmed_head.h"

namespace likeness {
namespace {

// All faces rest, but for what each of `shown` performs in a third of the views.
TrainingSet performing(const FilmedHead& head, const std::vector<std::pair<const char*, float>>& shown) {
  TrainingSet set = filmed_set(head, 12, 2, 16);
  for (std::size_t v = 0; v < set.views.size(); v += 3)
    for (const auto& [name, amount] : shown)
      for (const char* side : {"", "_L", "_R"})
        if (const NamedAction* action = find_action(set.model, std::string(name) + side))
          add_action(set.views[v].pose.articulation, *action, amount);
  return set;
}

const UnseenAction* unseen_action(const UnseenExpressions& unseen, const std::string& name) {
  for (const UnseenAction& action : unseen.actions)
    if (unseen.basis.actions[action.sides[0]].name.starts_with(name)) return &action;
  return nullptr;
}

TEST(UnseenExpressions, AreThoseThatTheClipDoesNotShow) {
  const FilmedHead head;
  const UnseenExpressions unseen =
      unseen_expressions(performing(head, {{"jawOpen", 1.f}, {"mouthSmile", 0.4f}}));
  EXPECT_EQ(unseen_action(unseen, "jawOpen"), nullptr);
  const UnseenAction* smile = unseen_action(unseen, "mouthSmile");
  ASSERT_NE(smile, nullptr);
  EXPECT_EQ(smile->sides.size(), 2u);
  EXPECT_NEAR(smile->seen, 0.4f, 0.1f);
  ASSERT_NE(unseen_action(unseen, "eyeBlink"), nullptr);
  EXPECT_NEAR(unseen_action(unseen, "eyeBlink")->seen, 0, 0.1f);
  EXPECT_EQ(unseen_action(unseen, "eyeLook"), nullptr);
  EXPECT_EQ(unseen.common.size(), 1u) << "the blink";
}

TEST(UnseenExpressions, AreDrawnBeyondWhatWasSeen) {
  const FilmedHead head;
  const TrainingSet set = performing(head, {{"mouthSmile", 0.4f}});
  const UnseenExpressions unseen = unseen_expressions(set);
  double widest_jaw = 0;
  int beyond = 0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    RandomStream random(7, 0, i);
    const Articulation drawn = draw_unseen(unseen, set.views[0].pose.articulation, random);  // smiles by 0.4
    RandomStream again(7, 0, i);
    EXPECT_EQ(drawn.expression, draw_unseen(unseen, set.views[0].pose.articulation, again).expression);
    widest_jaw = std::max(widest_jaw, double(drawn.jaw.norm()));
    EXPECT_TRUE(((drawn.expression.array() <= set.model.expression_max.array() + 0.05f).all()));
    beyond += (drawn.expression - set.views[0].pose.articulation.expression).norm() > 0.2f ||
              drawn.jaw.norm() > 0.05f;
  }
  EXPECT_GT(beyond, 35);
  EXPECT_GT(widest_jaw, 0.2);
}

// Lips that part at rest: no more is asked of them than lies beyond that.
TEST(UnseenExpressions, CountFromTheFaceAtRest) {
  const FilmedHead head;
  TrainingSet set = performing(head, {});
  for (TrainingView& view : set.views)
    add_action(view.pose.articulation, *find_action(set.model, "jawOpen"), 0.3f);
  const UnseenExpressions unseen = unseen_expressions(set);
  const UnseenAction* jaw = unseen_action(unseen, "jawOpen");
  ASSERT_NE(jaw, nullptr);
  EXPECT_NEAR(jaw->seen, 0, 0.05f);
  const Eigen::VectorXf rest = action_amounts(unseen.basis, set.views[0].pose.articulation);
  for (std::uint64_t i = 0; i < 40; ++i) {
    RandomStream random(7, 0, i);
    const Eigen::VectorXf drawn =
        action_amounts(unseen.basis, draw_unseen(unseen, set.views[0].pose.articulation, random));
    EXPECT_GT(drawn[Eigen::Index(jaw->sides[0])], rest[Eigen::Index(jaw->sides[0])] - 0.1f)
        << "the mouth shuts";
  }
}

TEST(UnseenExpressions, AModelWithoutActionsHasNone) {
  const FilmedHead head;
  TrainingSet set = performing(head, {});
  set.model.actions.clear();
  const UnseenExpressions unseen = unseen_expressions(set);
  EXPECT_TRUE(unseen.actions.empty());
  RandomStream random(1, 0, 0);
  EXPECT_EQ(draw_unseen(unseen, set.views[0].pose.articulation, random).expression,
            set.views[0].pose.articulation.expression);
}

}  // namespace
}  // namespace likeness
