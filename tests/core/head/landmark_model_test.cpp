// Claims about the reduced model: equal to the whole one, with right derivatives.
#include "core/head/landmark_model.h"

#include <gtest/gtest.h>

#include "core/head/pose_head.h"
#include "tests/core/head/ict_head.h"
#include "tests/core/head/synthetic_head.h"

namespace likeness {
namespace {

JointRotations<double> rotations_of(const Articulation& articulation) {
  return {articulation.neck.cast<double>(), articulation.jaw.cast<double>(),
          articulation.left_eye.cast<double>(), articulation.right_eye.cast<double>()};
}

void expect_agreement(const HeadModel& model, const std::vector<int>& vertices) {
  const LandmarkModel reduced = make_landmark_model(model, vertices);
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Eigen::VectorXf identity = random_coefficients(model.identity_count(), seed + 9, 0.5f);
    Articulation articulation = random_articulation(model, seed);
    if (seed == 0) articulation = neutral_articulation(model);
    const std::vector<Vec3f> posed = pose_head(model, shape_head(model, identity), articulation);
    const Eigen::VectorXd id = identity.cast<double>(), expression = articulation.expression.cast<double>();
    const LandmarkPositions positions =
        landmark_positions(reduced, id, expression, rotations_of(articulation));
    const auto templated =
        landmark_positions_of<double>(reduced, id.data(), expression.data(), rotations_of(articulation));
    const LandmarkPositions baked =
        landmark_positions(with_identity(reduced, id), {}, expression, rotations_of(articulation));
    for (std::size_t n = 0; n < vertices.size(); ++n) {
      const Vec3d expected = posed[vertices[n]].cast<double>();
      ASSERT_LT((positions.points.col(n) - expected).norm(), 1e-6)
          << "vertex " << vertices[n] << " seed " << seed;
      ASSERT_LT((templated.col(n) - positions.points.col(n)).norm(), 1e-12);
      ASSERT_LT((baked.points.col(n) - positions.points.col(n)).norm(), 1e-12);
    }
  }
}

TEST(LandmarkModel, AgreesWithPoseHeadOnAnyVertexList) {
  expect_agreement(synthetic_head(), {17, 3, 3, 99, 0, 119});
}

TEST(LandmarkModel, AgreesWithPoseHeadOnTheIctHead) {
  LIKENESS_NEED_ICT_HEAD(model);
  std::vector<int> vertices = nearest_landmark_vertices(model);
  vertices.push_back(8879);  // and one on an eyeball
  expect_agreement(model, vertices);
}

TEST(LandmarkModel, CombinedLandmarksEqualThoseOfThePosedMesh) {
  const HeadModel model = synthetic_head();
  const LandmarkModel reduced = make_landmark_model(model, landmark_vertices(model));
  const Articulation articulation = random_articulation(model, 7);
  const auto expected = landmark_positions(model, pose_head(model, shape_head(model, {}), articulation));
  const Eigen::Matrix3Xd combined = combine_landmarks(
      model,
      landmark_positions(reduced, {}, articulation.expression.cast<double>(), rotations_of(articulation))
          .points);
  for (int l = 0; l < kLandmarkCount; ++l)
    EXPECT_LT((combined.col(l) - expected[l].cast<double>()).norm(), 1e-6);
}

// Central differences of one coefficient against the column of the analytic derivative.
void expect_derivatives(const JointRotations<double>& rotations) {
  const HeadModel model = synthetic_head();
  const LandmarkModel reduced = make_landmark_model(model, std::vector<int>{4, 50, 88, 111});
  const Eigen::VectorXd identity = random_coefficients(model.identity_count(), 1).cast<double>();
  const Eigen::VectorXd expression = random_coefficients(model.expression_count(), 2).cast<double>();
  const LandmarkPositions at =
      landmark_positions(reduced, identity, expression, rotations, {true, true, true});
  const double step = 1e-5;
  const auto compare = [&](const Eigen::MatrixXd& analytic, int column, auto evaluate) {
    const Eigen::Matrix3Xd difference = (evaluate(step).points - evaluate(-step).points) / (2 * step);
    const Eigen::Map<const Eigen::VectorXd> flat(difference.data(), difference.size());
    EXPECT_LT((analytic.col(column) - flat).cwiseAbs().maxCoeff(), 1e-9) << "column " << column;
    EXPECT_GT(flat.norm(), 1e-6) << "column " << column << " moves nothing";
  };
  for (int c = 0; c < identity.size(); ++c)
    compare(at.identity, c, [&](double h) {
      return landmark_positions(reduced, identity + h * Eigen::VectorXd::Unit(identity.size(), c), expression,
                                rotations);
    });
  for (int c = 0; c < expression.size(); ++c)
    compare(at.expression, c, [&](double h) {
      return landmark_positions(reduced, identity,
                                expression + h * Eigen::VectorXd::Unit(expression.size(), c), rotations);
    });
  for (int c = 0; c < 12; ++c)
    compare(at.rotation, c, [&](double h) {
      JointRotations<double> moved = rotations;
      moved[c / 3][c % 3] += h;
      return landmark_positions(reduced, identity, expression, moved);
    });
}

TEST(LandmarkModel, DerivativesEqualFiniteDifferences) {
  const Articulation articulation = random_articulation(synthetic_head(), 3);
  expect_derivatives(rotations_of(articulation));
}

TEST(LandmarkModel, DerivativesHoldAtZeroRotation) {
  expect_derivatives({Vec3d::Zero(), Vec3d::Zero(), Vec3d::Zero(), Vec3d::Zero()});
}

TEST(RotationFromVector, IsSmoothThroughZeroAndOrthogonal) {
  for (const double angle : {0.0, 1e-9, 0.9e-6, 1.1e-6, 1e-3, 1.0, 3.1}) {
    const Vec3d vector = angle * Vec3d(1, -2, 2) / 3;
    const Mat3d expected =
        angle > 0 ? Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix() : Mat3d::Identity();
    EXPECT_LT((rotation_from_vector<double>(vector) - expected).norm(), 1e-12) << angle;
  }
}

}  // namespace
}  // namespace likeness
