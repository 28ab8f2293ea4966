// Claims about the content hash and the table of actions.
#include "core/head/head_model.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/head/named_actions.h"
#include "core/head/pose_head.h"
#include "tests/core/head/synthetic_head.h"

namespace likeness {
namespace {

TEST(ContentHash, ChangesWithEveryPartOfTheModelButItsName) {
  const HeadModel base = synthetic_head();
  const std::string hash = content_hash(base);
  EXPECT_EQ(hash, content_hash(synthetic_head()));
  HeadModel renamed = base;
  renamed.name = "another";
  EXPECT_EQ(hash, content_hash(renamed));
  const auto changed = [&](auto change) {
    HeadModel model = base;
    change(model);
    return content_hash(model);
  };
  EXPECT_NE(hash, changed([](HeadModel& m) { m.vertices[3].x() += 1e-6f; }));
  EXPECT_NE(hash, changed([](HeadModel& m) { m.identity_basis(5, 1) += 1e-6f; }));
  EXPECT_NE(hash, changed([](HeadModel& m) { m.expression_basis(5, 1) += 1e-6f; }));
  EXPECT_NE(hash, changed([](HeadModel& m) { m.pose_basis(5, 16) += 1e-6f; }));
  EXPECT_NE(hash, changed([](HeadModel& m) { m.joint_regressor(2, 7) += 1e-6f; }));
  EXPECT_NE(hash, changed([](HeadModel& m) { m.skinning_weights(7, 2) += 1e-6f; }));
  EXPECT_NE(hash, changed([](HeadModel& m) { m.parents[4] = 0; }));
  EXPECT_NE(hash, changed([](HeadModel& m) { std::swap(m.triangles[0], m.triangles[1]); }));
  EXPECT_NE(hash, changed([](HeadModel& m) { m.landmark_triangle[9] += 1; }));
  EXPECT_NE(hash, changed([](HeadModel& m) { m.landmark_barycentric[9] = {1, 0, 0}; }));
  EXPECT_NE(hash, changed([](HeadModel& m) { m.parts[4] = HeadPart::torso; }));
  EXPECT_NE(hash, changed([](HeadModel& m) { std::swap(m.expression_names[0], m.expression_names[1]); }));
}

TEST(NamedActions, EachNamedExpressionIsItsOwnCoefficient) {
  HeadModel model = synthetic_head();
  model.actions = make_named_actions(model);
  ASSERT_EQ(model.actions.size(), model.expression_names.size());
  const NamedAction* smile = find_action(model, "mouthSmile_L");
  ASSERT_NE(smile, nullptr);
  EXPECT_EQ(smile->expression, Eigen::VectorXf::Unit(4, 1));
  EXPECT_EQ(smile->jaw, Vec3f::Zero());
  EXPECT_EQ(find_action(model, "mouthSmile_R"), nullptr);
}

TEST(NamedActions, JawOpenStaysAShapeWhereNoJawRotationMakesIt) {
  const HeadModel model = synthetic_head();  // random jawOpen shape
  const std::vector<NamedAction> actions = make_named_actions(model);
  EXPECT_EQ(actions[0].expression, Eigen::VectorXf::Unit(4, 0));
  EXPECT_EQ(actions[0].jaw, Vec3f::Zero());
}

TEST(NamedActions, JawOpenBecomesTheJawRotationThatMakesItsShape) {
  HeadModel model = synthetic_head();
  const float angle = 0.3f;
  Articulation open = neutral_articulation(model);
  open.jaw = {angle, 0, 0};
  const std::vector<Vec3f> posed = pose_head(model, shape_head(model, PersonShape{}), open);
  for (int v = 0; v < model.vertex_count(); ++v)
    model.expression_basis.col(0).segment<3>(3 * v) = posed[v] - model.vertices[v];
  const JawMatch match = match_jaw_rotation(model, 0);
  EXPECT_NEAR(match.angle, angle, 2e-4f);
  EXPECT_LT(match.relative_residual, 1e-3f);
  const std::vector<NamedAction> actions = make_named_actions(model);
  EXPECT_TRUE(actions[0].expression.isZero(0));
  EXPECT_NEAR(actions[0].jaw.x(), angle, 2e-4f);
}

TEST(NamedActions, GazeTurnsTheEyeballTheWayTheNameSays) {
  HeadModel model = synthetic_head();
  model.actions = make_named_actions(model);
  const auto gaze = [](const Vec3f& rotation) {
    return Vec3f(Eigen::AngleAxisf(rotation.norm(), rotation.normalized()) * Vec3f(0, 0, 1));
  };
  const NamedAction* up = find_action(model, "eyeLookUp_L");
  EXPECT_GT(gaze(up->left_eye).y(), 0.2f);
  EXPECT_EQ(up->right_eye, Vec3f::Zero());
  // The subject's right eye lies at -x; inward is towards +x.
  EXPECT_GT(gaze(find_action(model, "eyeLookIn_R")->right_eye).x(), 0.2f);
}

TEST(AddAction, AddsCoefficientsAndRotationsInProportion) {
  HeadModel model = synthetic_head();
  model.actions = make_named_actions(model);
  Articulation articulation = neutral_articulation(model);
  EXPECT_TRUE(articulation.expression.isZero(0));
  const NamedAction& up = *find_action(model, "eyeLookUp_L");
  add_action(articulation, up, 0.25f);
  add_action(articulation, up, 0.5f);
  EXPECT_TRUE(articulation.expression.isApprox(0.75f * up.expression));
  EXPECT_TRUE(articulation.left_eye.isApprox(0.75f * up.left_eye));
}

}  // namespace
}  // namespace likeness
