// Claims about the learnt condition.
#include "core/train/condition_map.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

std::vector<Articulation> random_articulations(float first, float second) {
  std::mt19937 engine(1);
  std::normal_distribution<float> normal;
  std::vector<Articulation> list(200);
  for (Articulation& a : list) {
    a.expression.resize(2);
    a.expression << first * normal(engine), second * normal(engine);
  }
  return list;
}

TEST(LearnConditionMap, OrdersByTheMotionThatIsSeenNotByTheCoefficients) {
  const HeadModel model = ball_head();
  const HeadShape shape = shape_head(model, PersonShape{});
  // "top" varies twice as much as "bulge" but moves a twentieth as far.
  const auto map = learn_condition_map(model, shape, random_articulations(1, 2));
  ASSERT_GE(map.rows.rows(), 1);
  EXPECT_GT(std::abs(map.rows(0, 0)), 5 * std::abs(map.rows(0, 1)));
}

TEST(LearnConditionMap, FirstComponentHasDeviationOneHalfAndTheMeanIsZero) {
  const HeadModel model = ball_head();
  const auto list = random_articulations(0.7f, 0.1f);
  const auto map = learn_condition_map(model, shape_head(model, PersonShape{}), list);
  double sum = 0, squares = 0;
  for (const Articulation& a : list) {
    const double psi = condition(map, a)[0];
    sum += psi, squares += psi * psi;
  }
  EXPECT_NEAR(sum / 200, 0, 1e-4);
  EXPECT_NEAR(std::sqrt(squares / 200), 0.5, 1e-3);
}

TEST(LearnConditionMap, ClampsWhatTrainingNeverSaw) {
  const HeadModel model = ball_head();
  const auto list = random_articulations(1, 0.3f);
  const auto map = learn_condition_map(model, shape_head(model, PersonShape{}), list);
  Articulation wild = list[0];
  wild.expression *= 1000;
  float most = 0;
  for (const Articulation& a : list) most = std::max(most, std::abs(condition(map, a)[0]));
  EXPECT_LT(std::abs(condition(map, wild)[0]), 1.5f * most);
  EXPECT_GT(std::abs(condition(map, wild)[0]), 0.4f * most);
}

TEST(LearnConditionMap, AFaceThatNeverMovesHasNoCondition) {
  const HeadModel model = ball_head();
  const auto map = learn_condition_map(model, shape_head(model, PersonShape{}), random_articulations(0, 0));
  EXPECT_EQ(map.rows.rows(), 0);
}

TEST(LearnConditionMap, GazeIsAddedOnlyWhereItVaries) {
  const HeadModel model = ball_head();
  auto list = random_articulations(1, 0);
  const auto still = learn_condition_map(model, shape_head(model, PersonShape{}), list);
  for (std::size_t i = 0; i < list.size(); ++i)
    list[i].left_eye.y() = list[i].right_eye.y() = i % 2 ? 0.2f : -0.2f;
  const auto moving = learn_condition_map(model, shape_head(model, PersonShape{}), list);
  EXPECT_EQ(moving.rows.rows(), still.rows.rows() + 1);
  EXPECT_GT(condition(moving, list[1])[moving.rows.rows() - 1],
            condition(moving, list[0])[moving.rows.rows() - 1]);
}

}  // namespace
}  // namespace likeness
