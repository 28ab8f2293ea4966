// Claims about named actions for a model without names: on a model that can represent them they are
// recovered.
#include "core/head/transfer_actions.h"

#include <gtest/gtest.h>
#include <Eigen/QR>

#include <random>

#include "core/head/pose_head.h"
#include "tests/core/head/builtin.h"

namespace likeness {
namespace {

// The built-in head as FLAME would be: nameless expressions, mixed by a random rotation, nothing known of
// parts.
HeadModel nameless(const HeadModel& model) {
  HeadModel mixed = model;
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  const int count = model.expression_count();
  const Eigen::MatrixXf noise = Eigen::MatrixXf::NullaryExpr(count, count, [&] { return normal(random); });
  const Eigen::MatrixXf rotation = Eigen::HouseholderQR<Eigen::MatrixXf>(noise).householderQ();
  mixed.expression_basis = model.expression_basis * rotation;
  mixed.expression_names.clear();
  mixed.actions.clear();
  for (HeadPart& part : mixed.parts)
    if (part != HeadPart::left_eyeball && part != HeadPart::right_eyeball) part = HeadPart::unknown;
  mixed.expression_min = Eigen::VectorXf::Constant(count, -3), mixed.expression_max = -mixed.expression_min;
  return mixed;
}

// Motion of the face's skin; the gaze of the eyeballs is not part of an expression.
std::vector<Vec3f> motion(const HeadModel& model, const NamedAction& action) {
  const HeadShape shape = shape_head(model, PersonShape{});
  Articulation articulation = neutral_articulation(model);
  add_action(articulation, action, 1);
  articulation.left_eye.setZero(), articulation.right_eye.setZero();
  std::vector<Vec3f> posed = pose_head(model, shape, articulation);
  for (std::size_t v = 0; v < posed.size(); ++v) posed[v] -= shape.vertices[v];
  return posed;
}

double relative_error(const std::vector<Vec3f>& got, const std::vector<Vec3f>& want) {
  double off = 0, size = 0;
  for (std::size_t v = 0; v < want.size(); ++v) {
    if (builtin().parts[v] != HeadPart::face) continue;
    off += double((got[v] - want[v]).squaredNorm());
    size += double(want[v].squaredNorm());
  }
  return std::sqrt(off / size);
}

TEST(TransferActions, AreRecoveredInAMixedBasis) {
  const HeadModel target = nameless(builtin());
  const std::vector<NamedAction> actions = transfer_actions(builtin(), target);
  EXPECT_EQ(actions.size(), builtin().actions.size());
  double worst = 0;
  for (const NamedAction& action : actions) {
    const double error =
        relative_error(motion(target, action), motion(builtin(), *find_action(builtin(), action.name)));
    EXPECT_LT(error, 0.10) << action.name << ", residual " << action.residual;
    worst = std::max(worst, error);
  }
  RecordProperty("worst_motion_error", std::to_string(worst));
  std::printf("worst motion error %.4f\n", worst);
}

TEST(TransferActions, AnotherSizeAndPlaceChangeOnlyTheSize) {
  HeadModel target = nameless(builtin());
  const float scale = 0.8f;
  for (Vec3f& v : target.vertices) v = scale * v + Vec3f(0.02f, -0.05f, 0.1f);
  target.expression_basis *= scale;
  const std::vector<NamedAction> actions = transfer_actions(builtin(), target);
  ASSERT_EQ(actions.size(), builtin().actions.size());
  for (const NamedAction& action : actions) {
    std::vector<Vec3f> want = motion(builtin(), *find_action(builtin(), action.name));
    for (Vec3f& v : want) v *= scale;
    EXPECT_LT(relative_error(motion(target, action), want), 0.10) << action.name;
  }
}

TEST(TransferActions, OfAnotherPersonStayTheSameActions) {
  HeadModel target = nameless(builtin());
  Eigen::VectorXf identity = Eigen::VectorXf::Zero(target.identity_count());
  identity.head(4) << 1.5f, -1, 1, -1.5f;
  target.vertices = shape_head(builtin(), identity).vertices;
  const std::vector<NamedAction> actions = transfer_actions(builtin(), target);
  EXPECT_GE(actions.size(), builtin().actions.size() - 4);
  int good = 0;
  for (const NamedAction& action : actions)
    good +=
        relative_error(motion(target, action), motion(builtin(), *find_action(builtin(), action.name))) < 0.3;
  EXPECT_GE(good, int(actions.size()) * 8 / 10);
}

TEST(TransferActions, ActionsAModelCannotMakeAreLeftOutOrMarked) {
  HeadModel target = nameless(builtin());
  target.expression_basis = builtin().expression_basis.leftCols(3);  // brows only
  target.expression_min = Eigen::VectorXf::Zero(3), target.expression_max = Eigen::VectorXf::Ones(3);
  for (const NamedAction& action : transfer_actions(builtin(), target))
    EXPECT_TRUE(action.name.starts_with("brow") || action.residual > 0.2 || action.name == "jawOpen")
        << action.name;
}

TEST(TransferActions, FaceThatDoesNotCorrespondGetsNone) {
  HeadModel target = nameless(builtin());
  std::mt19937 random(1);
  for (int& triangle : target.landmark_triangle) triangle = int(random() % target.triangles.size());
  EXPECT_TRUE(transfer_actions(builtin(), target).empty());
}

}  // namespace
}  // namespace likeness
