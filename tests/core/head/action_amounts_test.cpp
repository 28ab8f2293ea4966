// Claims about recovering actions from coefficients.
#include "core/head/action_amounts.h"

#include <gtest/gtest.h>

#include "core/head/builtin_head.h"
#include "tests/core/head/ict_head.h"

namespace likeness {
namespace {

// Every third action at a fifth to a half, eyes excepted.
std::vector<float> mixture(const HeadModel& model) {
  std::vector<float> amounts(model.actions.size(), 0.0f);
  for (std::size_t a = 0; a < amounts.size(); a += 3)
    if (!model.actions[a].name.starts_with("eyeLook")) amounts[a] = 0.2f + 0.1f * float(a % 4);
  return amounts;
}

void expect_found_again(const HeadModel& model) {
  const ActionBasis basis = action_basis(model);
  const std::vector<float> amounts = mixture(model);
  Articulation face = neutral_articulation(model);
  for (std::size_t a = 0; a < amounts.size(); ++a) add_action(face, model.actions[a], amounts[a]);
  const Eigen::VectorXf found = face_amounts(basis, face);
  for (std::size_t a = 0; a < amounts.size(); ++a)
    EXPECT_NEAR(found[Eigen::Index(a)], amounts[a], 0.02) << model.actions[a].name;
}

TEST(ActionAmounts, RecoversAMixtureOfActionsBuiltIn) { expect_found_again(make_builtin_head()); }

TEST(ActionAmounts, RecoversAMixtureOfActionsIct) {
  LIKENESS_NEED_ICT_HEAD(model);
  expect_found_again(model);
}

TEST(ActionAmounts, AreLinearInTheFace) {
  const HeadModel model = make_builtin_head();
  const ActionBasis basis = action_basis(model);
  Articulation one = neutral_articulation(model), two = one, sum = one;
  one.expression.setLinSpaced(0.0f, 0.4f), two.expression.setLinSpaced(0.3f, 0.0f);
  one.jaw = {0.1f, 0, 0}, two.jaw = {0.05f, 0.02f, 0};
  sum.expression = 2 * one.expression + two.expression, sum.jaw = 2 * one.jaw + two.jaw;
  const Eigen::VectorXf expected = 2 * face_amounts(basis, one) + face_amounts(basis, two);
  EXPECT_LT((face_amounts(basis, sum) - expected).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(ActionAmounts, GazeIsReadFromTheEyeball) {
  const HeadModel model = make_builtin_head();
  const ActionBasis basis = action_basis(model);
  const NamedAction* look = find_action(model, "eyeLookOut_L");
  ASSERT_NE(look, nullptr);
  Articulation face = neutral_articulation(model);
  face.left_eye = 0.5f * look->left_eye;
  const Eigen::VectorXf amounts = action_amounts(basis, face);
  EXPECT_NEAR(amounts[action_index(basis, "eyeLookOut_L")], 0.5, 1e-3);
  EXPECT_EQ(amounts[action_index(basis, "eyeLookIn_L")], 0);
  EXPECT_EQ(amounts[action_index(basis, "eyeLookOut_R")], 0);
}

}  // namespace
}  // namespace likeness
