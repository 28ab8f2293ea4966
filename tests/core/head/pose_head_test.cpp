// Claims about posing: what FLAME's definition implies, on a random model and, where present, on ICT-FaceKit.
#include "core/head/pose_head.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/base/rigid.h"
#include "tests/core/head/ict_head.h"
#include "tests/core/head/synthetic_head.h"

namespace likeness {
namespace {

float largest_distance(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
  EXPECT_EQ(a.size(), b.size());
  float largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

// FLAME's definition written down a second time, slowly, in double and with 4x4 matrices.
std::vector<Vec3f> reference_pose(const HeadModel& model, const Eigen::VectorXf& identity,
                                  const Articulation& articulation) {
  const int count = model.vertex_count();
  Eigen::VectorXd shaped(3 * count);
  for (int v = 0; v < count; ++v) shaped.segment<3>(3 * v) = model.vertices[v].cast<double>();
  shaped += model.identity_basis.cast<double>() * identity.cast<double>();
  shaped += model.expression_basis.cast<double>() * articulation.expression.cast<double>();
  Eigen::MatrixXd joints = Eigen::MatrixXd::Zero(kJointCount, 3);
  for (int j = 0; j < kJointCount; ++j)
    for (int v = 0; v < count; ++v)
      joints.row(j) += double(model.joint_regressor(j, v)) * shaped.segment<3>(3 * v).transpose();
  std::array<Vec3d, kJointCount> vectors = {
      Vec3d::Zero(), articulation.neck.cast<double>(), articulation.jaw.cast<double>(),
      articulation.left_eye.cast<double>(), articulation.right_eye.cast<double>()};
  std::array<Mat3d, kJointCount> rotation;
  for (int j = 0; j < kJointCount; ++j) {
    const double angle = vectors[j].norm();
    rotation[j] = angle > 0 ? rotation_about(vectors[j] / angle, angle) : Mat3d::Identity();
  }
  Eigen::VectorXd features(kPoseFeatureCount);
  for (int j = 1; j < kJointCount; ++j)
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) features[9 * (j - 1) + 3 * r + c] = rotation[j](r, c) - (r == c);
  shaped += model.pose_basis.cast<double>() * features;
  std::array<Eigen::Matrix4d, kJointCount> global;
  for (int j = 0; j < kJointCount; ++j) {
    Eigen::Matrix4d local = Eigen::Matrix4d::Identity();
    local.topLeftCorner<3, 3>() = rotation[j];
    const int parent = model.parents[j];
    local.topRightCorner<3, 1>() = joints.row(j).transpose();
    if (parent >= 0) local.topRightCorner<3, 1>() -= joints.row(parent).transpose();
    global[j] = parent >= 0 ? Eigen::Matrix4d(global[parent] * local) : local;
  }
  std::vector<Vec3f> posed(count);
  for (int v = 0; v < count; ++v) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (int j = 0; j < kJointCount; ++j) {
      Eigen::Matrix4d rest = Eigen::Matrix4d::Identity();
      rest.topRightCorner<3, 1>() = -joints.row(j).transpose();
      const Eigen::Vector4d point(shaped[3 * v], shaped[3 * v + 1], shaped[3 * v + 2], 1);
      sum += double(model.skinning_weights(v, j)) * (global[j] * rest * point);
    }
    posed[v] = sum.head<3>().cast<float>();
  }
  return posed;
}

TEST(PoseHead, ZeroParametersReproduceTheTemplate) {
  const HeadModel model = synthetic_head();
  const HeadShape shape = shape_head(model, Eigen::VectorXf::Zero(model.identity_count()));
  EXPECT_EQ(largest_distance(pose_head(model, shape, neutral_articulation(model)), model.vertices), 0);
}

TEST(PoseHead, AgreesWithTheDefinitionInDouble) {
  const HeadModel model = synthetic_head();
  for (unsigned seed = 0; seed < 8; ++seed) {
    const Eigen::VectorXf identity = random_coefficients(model.identity_count(), seed + 40);
    const Articulation articulation = random_articulation(model, seed);
    const std::vector<Vec3f> posed = pose_head(model, shape_head(model, identity), articulation);
    EXPECT_LT(largest_distance(posed, reference_pose(model, identity, articulation)), 1e-6f)
        << "seed " << seed;
  }
}

TEST(PoseHead, ShorterCoefficientsArePaddedWithZero) {
  const HeadModel model = synthetic_head();
  const Eigen::VectorXf two = random_coefficients(2, 5);
  Eigen::VectorXf all = Eigen::VectorXf::Zero(model.identity_count());
  all.head(2) = two;
  const HeadShape shape = shape_head(model, two), padded = shape_head(model, all);
  EXPECT_EQ(largest_distance(shape.vertices, padded.vertices), 0);
  Articulation short_one = random_articulation(model, 3), long_one = short_one;
  short_one.expression = two;
  long_one.expression.setZero();
  long_one.expression.head(2) = two;
  EXPECT_EQ(largest_distance(pose_head(model, shape, short_one), pose_head(model, shape, long_one)), 0);
}

TEST(PoseHead, VerticesOfOneJointMoveRigidlyAboutIt) {
  HeadModel model = synthetic_head();
  model.pose_basis.resize(model.pose_basis.rows(), 0);
  // Upper half on the neck joint, lower half on the root.
  for (int v = 0; v < model.vertex_count(); ++v)
    model.skinning_weights.row(v) =
        Eigen::RowVectorXf::Unit(kJointCount, model.vertices[v].y() > 0 ? kNeck : kRoot);
  const HeadShape shape = shape_head(model, PersonShape{});
  Articulation articulation = neutral_articulation(model);
  articulation.neck = {0.2f, -0.5f, 0.1f};
  const Eigen::AngleAxisf turn(articulation.neck.norm(), articulation.neck.normalized());
  const std::vector<Vec3f> posed = pose_head(model, shape, articulation);
  for (int v = 0; v < model.vertex_count(); ++v) {
    const Vec3f expected = model.vertices[v].y() > 0
                               ? Vec3f(shape.joints[kNeck] + turn * (shape.vertices[v] - shape.joints[kNeck]))
                               : shape.vertices[v];
    ASSERT_LT((posed[v] - expected).norm(), 1e-6f) << "vertex " << v;
  }
}

TEST(PoseHead, JawAndEyesFollowTheNeck) {
  HeadModel model = synthetic_head();
  model.pose_basis.resize(model.pose_basis.rows(), 0);
  // With all weight on the jaw, turning only the neck must still turn everything about the neck.
  for (int v = 0; v < model.vertex_count(); ++v)
    model.skinning_weights.row(v) = Eigen::RowVectorXf::Unit(kJointCount, kJaw);
  const HeadShape shape = shape_head(model, PersonShape{});
  Articulation articulation = neutral_articulation(model);
  articulation.neck = {0, 0.6f, 0};
  const Eigen::AngleAxisf turn(0.6f, Vec3f::UnitY());
  const std::vector<Vec3f> posed = pose_head(model, shape, articulation);
  for (int v = 0; v < model.vertex_count(); ++v)
    ASSERT_LT((posed[v] - (shape.joints[kNeck] + turn * (shape.vertices[v] - shape.joints[kNeck]))).norm(),
              1e-6f);
}

TEST(LandmarkPositions, AreTheBarycentricPointsOfTheirTriangles) {
  const HeadModel model = synthetic_head();
  const std::vector<Vec3f> posed =
      pose_head(model, shape_head(model, PersonShape{}), random_articulation(model, 2));
  const auto landmarks = landmark_positions(model, posed);
  for (int l = 0; l < kLandmarkCount; ++l) {
    Eigen::Matrix3f corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = posed[model.triangles[model.landmark_triangle[l]][k]];
    EXPECT_LT((landmarks[l] - corners * model.landmark_barycentric[l]).norm(), 1e-7f);
  }
}

TEST(VertexNormals, PointOutwardOnAConvexSurface) {
  const HeadModel model = synthetic_head();
  const std::vector<Vec3f> normals = vertex_normals(model.vertices, model.triangles);
  for (int v = 0; v < model.vertex_count(); ++v) {
    EXPECT_NEAR(normals[v].norm(), 1, 1e-5f);
    EXPECT_GT(normals[v].dot(model.vertices[v]), 0) << "vertex " << v;
  }
}

TEST(IctHead, JawRotationOfTheJawOpenActionIsTheJawOpenShape) {
  LIKENESS_NEED_ICT_HEAD(model);
  const HeadShape shape = shape_head(model, PersonShape{});
  Articulation by_joint = neutral_articulation(model), by_shape = by_joint;
  const NamedAction* open = find_action(model, "jawOpen");
  ASSERT_NE(open, nullptr);
  EXPECT_TRUE(open->expression.isZero(0));
  EXPECT_NEAR(open->jaw.x() * 180 / std::numbers::pi, 25.33, 0.02);
  add_action(by_joint, *open, 1);
  const auto name = std::find(model.expression_names.begin(), model.expression_names.end(), "jawOpen");
  by_shape.expression[name - model.expression_names.begin()] = 1;
  const std::vector<Vec3f> rotated = pose_head(model, shape, by_joint),
                           blended = pose_head(model, shape, by_shape);
  EXPECT_GT(largest_distance(rotated, shape.vertices), 0.02f);  // it does open
  EXPECT_LT(largest_distance(rotated, blended), 1e-4f);
  const auto landmarks = landmark_positions(model, rotated),
             closed = landmark_positions(model, shape.vertices);
  EXPECT_LT(landmarks[8].y(), closed[8].y() - 0.01f);  // the chin goes down
}

TEST(IctHead, EyeballsTurnInPlace) {
  LIKENESS_NEED_ICT_HEAD(model);
  const HeadShape shape = shape_head(model, PersonShape{});
  Articulation articulation = neutral_articulation(model);
  articulation.left_eye = {0, 0.4f, 0};
  const std::vector<Vec3f> posed = pose_head(model, shape, articulation);
  for (int v = 0; v < model.vertex_count(); ++v) {
    if (model.parts[v] == HeadPart::left_eyeball)
      ASSERT_NEAR((posed[v] - shape.joints[kLeftEye]).norm(),
                  (shape.vertices[v] - shape.joints[kLeftEye]).norm(), 1e-6f);
    else
      ASSERT_LT((posed[v] - shape.vertices[v]).norm(), 1e-6f);
  }
}

}  // namespace
}  // namespace likeness
