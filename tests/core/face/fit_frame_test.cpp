// Claims about the fit of one frame.
#include "core/face/fit_frame.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rigid.h"
#include "core/head/pose_head.h"
#include "core/track/photo/photometric_mouth.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

Eigen::VectorXd some_identity(int count) {
  return Eigen::VectorXd::NullaryExpr(
      count, [](Eigen::Index i) { return 0.8 * std::sin(2.0 * static_cast<double>(i)); });
}

FaceState some_state(const ReducedHead& head, double yaw) {
  FaceState state;
  state.cam_from_head = facing_pose(yaw, 0.1, {0.02, 0.03, 0.6});
  state.jaw = 0.12;
  state.expression = Eigen::VectorXd::NullaryExpr(
      head.expression_count(), [](Eigen::Index i) { return 0.25 + 0.2 * std::sin(static_cast<double>(i)); });
  return state;
}

// The built-in head with jaw correctives of FLAME's kind: some millimetres as the jaw drops.
const HeadModel& corrected_head() {
  static const HeadModel model = [] {
    HeadModel m = test_head();
    m.pose_basis = decltype(m.pose_basis)::Zero(3 * m.vertex_count(), kPoseFeatureCount);
    for (Eigen::Index row = 0; row < m.pose_basis.rows(); ++row)
      for (int k = 9; k < 18; ++k)
        m.pose_basis(row, k) = 0.02f * std::sin(0.001f * float(row) + 2 * float(k));
    return m;
  }();
  return model;
}

class ReducedHeads : public testing::TestWithParam<bool> {
 protected:
  const HeadModel& model_ = GetParam() ? corrected_head() : test_head();
  const ReducedHead head_ = reduce_head(model_, 20);
};
INSTANTIATE_TEST_SUITE_P(WithAndWithoutCorrectives, ReducedHeads, testing::Bool());

TEST_P(ReducedHeads, PoseTheLandmarksAsTheWholeHeadDoes) {
  const HeadModel& model = model_;
  const ReducedHead& head = head_;
  const Eigen::VectorXd identity = some_identity(head.identity_count());
  const FaceState state = some_state(head, 0);
  Articulation whole = neutral_articulation(model);
  whole.expression = state.expression.cast<float>();
  whole.jaw.x() = static_cast<float>(state.jaw);
  const auto expected =
      landmark_positions(model, pose_head(model, shape_head(model, identity.cast<float>()), whole));
  const ReducedPerson person = reduced_person(head, identity);
  for (int i = 0; i < kLandmarkCount; ++i) {
    const Vec3d found = reduced_point(head, person, i, state.expression, state.jaw);
    EXPECT_LT((found - expected[i].cast<double>()).norm(), 2e-5) << "landmark " << i;
  }
}

TEST_P(ReducedHeads, DerivativesMatchFiniteDifferences) {
  const ReducedPerson person = reduced_person(head_, some_identity(head_.identity_count()));
  const FaceState state = some_state(head_, 0);
  const double jaw = 0.3, h = 1e-6;
  for (const int point : {8, 30, 57, 66}) {
    PointDerivatives by;
    (void)reduced_point(head_, person, point, state.expression, jaw, &by);
    const auto at = [&](double j, const Vec3d& shape, const Vec3d& joint) {
      ReducedPerson other = person;
      other.base.segment<3>(3 * point) += shape;
      other.jaw_joint += joint;
      return reduced_point(head_, other, point, state.expression, j);
    };
    const Vec3d none = Vec3d::Zero();
    const Vec3d by_jaw = (at(jaw + h, none, none) - at(jaw - h, none, none)) / (2 * h);
    EXPECT_LT((by.by_jaw - by_jaw).norm(), 1e-8) << "point " << point;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3d step = h * Vec3d::Unit(axis);
      EXPECT_LT((by.by_shape.col(axis) - (at(jaw, step, none) - at(jaw, -step, none)) / (2 * h)).norm(),
                1e-8);
      EXPECT_LT((by.by_joint.col(axis) - (at(jaw, none, step) - at(jaw, none, -step)) / (2 * h)).norm(),
                1e-8);
    }
  }
}

TEST(FrameSystem, GradientMatchesFiniteDifferences) {
  const ReducedHead& head = test_reduced_head();
  const Eigen::VectorXd identity = some_identity(head.identity_count());
  const ReducedPerson person = reduced_person(head, identity);
  const FaceState truth = some_state(head, 0.5);
  FaceObservation seen = observe_state(head, person, truth, 1.5, 3);
  seen.lids[0] = {true, 0.009, 0.004};  // in the linear and the limited range of its cost
  seen.lids[1] = {true, 0.0, 0.0005};
  seen.lips = {true, 0.004, 0.003};
  FaceState state = truth;
  state.cam_from_head = facing_pose(0.47, 0.13, {0.021, 0.029, 0.61});
  state.jaw = -0.02;  // beyond its range: the one-sided penalty acts
  state.expression *= 0.7;
  const ExpressionPrior prior = expression_prior(test_head());
  FramePull pull;
  pull.expression = Eigen::VectorXd::Constant(head.expression_count(), 0.1);
  pull.expression_weight = 4, pull.jaw = 0.05, pull.jaw_weight = 8;
  pull.shift_weight = 100, pull.cam_from_head = truth.cam_from_head;
  const JawLine line = pick_jaw_line(head, person, seen, state);
  const int face = 7 + head.expression_count(), all = face + head.identity_count();
  FrameSystem system;
  system.hessian.resize(all, all);
  frame_system(head, person, seen, line, prior, pull, {}, state, true, &system);
  const auto cost_at = [&](int k, double h) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(face);
    Eigen::VectorXd id = identity;
    (k < face ? step[k] : id[k - face]) += h;
    return frame_cost(head, reduced_person(head, id), seen, line, prior, pull, {}, moved(state, step));
  };
  for (int k = 0; k < all; ++k) {
    const double h = 1e-6;
    const double numeric = (cost_at(k, h) - cost_at(k, -h)) / (2 * h);
    EXPECT_NEAR(system.gradient[k], numeric, 1e-4 * std::max(10.0, std::abs(numeric))) << "unknown " << k;
  }
}

TEST(FitFrame, RecoversPoseFromNoisyLandmarks) {
  const ReducedHead& head = test_reduced_head();
  const ReducedPerson person = reduced_person(head, some_identity(head.identity_count()));
  const ExpressionPrior prior = expression_prior(test_head());
  for (double yaw : {-0.6, -0.2, 0.0, 0.35, 0.6}) {
    FaceState truth;
    truth.cam_from_head = facing_pose(yaw, 0.1, {0.02, 0.03, 0.6});
    truth.expression = Eigen::VectorXd::Zero(head.expression_count());
    FaceObservation seen = observe_state(head, person, truth, 0, 1);
    const JawLine line = pick_jaw_line(head, person, seen, truth);
    for (int i = 0; i < kJawLineCount; ++i)
      seen.rays[i] = (truth.cam_from_head * reduced_point(head, person, line.point[i], truth.expression, 0))
                         .hnormalized();
    std::mt19937 random(9);
    std::normal_distribution<double> normal(0, 1.0 / seen.focal_px);
    for (Vec2d& r : seen.rays) r += Vec2d(normal(random), normal(random));
    FaceState found = start_frame(head, person, seen, prior);
    for (int round = 0; round < 3; ++round) found = fit_frame(head, person, seen, prior, {}, {}, found);
    const double off =
        vector_from_turn(found.cam_from_head.linear() * truth.cam_from_head.linear().transpose()).norm();
    EXPECT_LT(off * 57.3, 3.0) << "degrees, at yaw " << yaw;
    EXPECT_LT((found.cam_from_head.translation() - truth.cam_from_head.translation()).head<2>().norm(),
              0.006);
    EXPECT_LT(inner_error(head, person, seen, found), 1.6);
  }
}

TEST(FitFrame, LipsGoWhereTheirEvidenceIsSurerThanTheLandmarks) {
  const ReducedHead& head = test_reduced_head();
  const ReducedPerson person = reduced_person(head, some_identity(head.identity_count()));
  const ExpressionPrior prior = expression_prior(test_head());
  FaceState shut = some_state(head, 0.2), open = shut;
  shut.jaw = 0.02, open.jaw = 0.22;
  const FaceObservation landmarks = observe_state(head, person, shut, 1.0, 5);
  const double wanted = lip_gap(head, person, open), fitted = lip_gap(head, person, shut);
  const auto gap_with = [&](double sigma_m) {
    FaceObservation seen = landmarks;
    observe_mouth({true, wanted, sigma_m}, fitted, &seen);
    return lip_gap(head, person, fit_frame(head, person, seen, prior, {}, {}, shut));
  };
  EXPECT_GT(gap_with(0.0001), fitted + 0.7 * (wanted - fitted));
  EXPECT_LT(gap_with(0.05), fitted + 0.1 * (wanted - fitted));
}

TEST(FitFrame, FollowsTheOpeningJaw) {
  const ReducedHead& head = test_reduced_head();
  const ReducedPerson person = reduced_person(head, Eigen::VectorXd::Zero(head.identity_count()));
  const ExpressionPrior prior = expression_prior(test_head());
  double last = -1;
  for (double jaw : {0.0, 0.1, 0.2, 0.3}) {
    FaceState truth;
    truth.cam_from_head = facing_pose(0, 0, {0, 0, 0.6});
    truth.expression = Eigen::VectorXd::Zero(head.expression_count());
    truth.jaw = jaw;
    const FaceObservation seen = observe_state(head, person, truth, 0, 1);
    const FaceState found =
        fit_frame(head, person, seen, prior, {}, {}, start_frame(head, person, seen, prior));
    EXPECT_NEAR(found.jaw, jaw, 0.07);
    EXPECT_GT(found.jaw, last);
    last = found.jaw;
  }
}

}  // namespace
}  // namespace likeness
