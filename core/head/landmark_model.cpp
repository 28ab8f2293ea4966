// Reduced head models and the analytic derivatives of their points. Notation in landmark_model.h.
#include "core/head/landmark_model.h"

#include <algorithm>

#include "core/base/check.h"

namespace likeness {
namespace {

using Mat3 = Eigen::Matrix3d;
using PerJoint = std::array<Mat3, kJointCount>;

constexpr int kRotationCount = 3 * (kJointCount - 1);

Mat3 cross_matrix(const Vec3d& v) {
  Mat3 k;
  k << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return k;
}

// d R(r) / d r_axis (Gallego and Yezzi 2015, closed form).
Mat3 rotation_derivative(const Vec3d& r, const Mat3& rotation, int axis) {
  const Vec3d unit = Vec3d::Unit(axis);
  const double squared = r.squaredNorm();
  if (squared < 1e-14) return cross_matrix(unit);
  const Vec3d turned = r.cross((Mat3::Identity() - rotation) * unit);
  return (r[axis] * cross_matrix(r) + cross_matrix(turned)) / squared * rotation;
}

// Rotations of the chain. Translation t_j = sum_i coupling[j][i] * joint_i is linear in the joints, which is
// what makes the derivative by identity and expression a product with joint_identity and joint_expression.
struct Chain {
  PerJoint local, rotation;
  std::array<PerJoint, kJointCount> coupling;
};

// From local rotations, and for the derivative by one local rotation from its derivative: the chain is linear
// in each of them, so the derivative of joint `moving` puts `change` in its place and drops whatever does not
// pass by it.
Chain make_chain(const std::array<int, kJointCount>& parents, const PerJoint& local) {
  Chain chain;
  chain.local = local;
  std::array<PerJoint, kJointCount> position;  // as coupling, of the posed joint positions
  for (int j = 0; j < kJointCount; ++j) {
    const int parent = parents[j];
    for (int i = 0; i < kJointCount; ++i) position[j][i] = parent < 0 ? Mat3::Zero() : position[parent][i];
    if (parent < 0) {
      chain.rotation[j] = local[j];
      position[j][j] += Mat3::Identity();
    } else {
      chain.rotation[j] = chain.rotation[parent] * local[j];
      position[j][j] += chain.rotation[parent];
      position[j][parent] -= chain.rotation[parent];
    }
    chain.coupling[j] = position[j];
    chain.coupling[j][j] -= chain.rotation[j];
  }
  return chain;
}

struct ChainChange {
  PerJoint rotation;
  std::array<Vec3d, kJointCount> translation;
};

ChainChange chain_derivative(const std::array<int, kJointCount>& parents, const Chain& chain,
                             const std::array<Vec3d, kJointCount>& joints, int moving, const Mat3& change) {
  ChainChange out;
  std::array<Vec3d, kJointCount> position;
  for (int j = 0; j < kJointCount; ++j) {
    const int parent = parents[j];
    out.rotation[j].setZero();
    position[j].setZero();
    if (parent >= 0) {
      out.rotation[j] = out.rotation[parent] * chain.local[j];
      if (j == moving) out.rotation[j] += chain.rotation[parent] * change;
      position[j] = position[parent] + out.rotation[parent] * (joints[j] - joints[parent]);
    }
    out.translation[j] = position[j] - out.rotation[j] * joints[j];
  }
  return out;
}

template <class Vector>
Eigen::VectorXd blend(const Eigen::VectorXd& base, const Eigen::MatrixXd& basis, const Vector& coefficients) {
  return base + basis.leftCols(coefficients.size()) * coefficients;
}

Eigen::MatrixXd rows_of(const Eigen::MatrixXf& basis, std::span<const int> vertices) {
  Eigen::MatrixXd rows(3 * Eigen::Index(vertices.size()), basis.cols());
  for (Eigen::Index n = 0; n < Eigen::Index(vertices.size()); ++n)
    rows.middleRows(3 * n, 3) = basis.middleRows(3 * Eigen::Index(vertices[n]), 3).cast<double>();
  return rows;
}

Eigen::MatrixXd regress_basis(const HeadModel& model, const Eigen::MatrixXf& basis) {
  Eigen::MatrixXd out(3 * kJointCount, basis.cols());
  for (Eigen::Index c = 0; c < basis.cols(); ++c) {
    const Eigen::Map<const Eigen::Matrix3Xf> shape(basis.col(c).data(), 3, model.vertex_count());
    const Eigen::Matrix<float, 3, kJointCount> joints = shape * model.joint_regressor.transpose();
    out.col(c) = Eigen::Map<const Eigen::VectorXf>(joints.data(), 3 * kJointCount).cast<double>();
  }
  return out;
}

// d points / d coefficients for coefficients that move points and joints linearly.
Eigen::MatrixXd coefficient_derivative(const LandmarkModel& model, const Chain& chain,
                                       const Eigen::MatrixXd& basis, const Eigen::MatrixXd& joint_basis) {
  std::array<Eigen::MatrixXd, kJointCount> translation;  // (3, C) d t_j
  for (int j = 0; j < kJointCount; ++j) {
    translation[j].setZero(3, basis.cols());
    for (int i = 0; i < kJointCount; ++i)
      if (!chain.coupling[j][i].isZero(0))
        translation[j].noalias() += chain.coupling[j][i] * joint_basis.middleRows<3>(3 * i);
  }
  Eigen::MatrixXd out(basis.rows(), basis.cols());
  for (Eigen::Index n = 0; n < model.point_count(); ++n) {
    Mat3 rotation = Mat3::Zero();
    for (int j = 0; j < kJointCount; ++j) rotation += model.weights(n, j) * chain.rotation[j];
    auto rows = out.middleRows<3>(3 * n);
    rows.noalias() = rotation * basis.middleRows<3>(3 * n);
    for (int j = 0; j < kJointCount; ++j)
      if (model.weights(n, j) != 0) rows += model.weights(n, j) * translation[j];
  }
  return out;
}

Eigen::MatrixXd rotation_derivatives(const LandmarkModel& model, const Chain& chain,
                                     const JointRotations<double>& rotations,
                                     const std::array<Vec3d, kJointCount>& joints,
                                     const Eigen::VectorXd& corrected) {
  Eigen::MatrixXd out(3 * Eigen::Index(model.point_count()), kRotationCount);
  for (int column = 0; column < kRotationCount; ++column) {
    const int joint = column / 3 + 1;
    const Mat3 change = rotation_derivative(rotations[joint - 1], chain.local[joint], column % 3);
    const ChainChange moved = chain_derivative(model.parents, chain, joints, joint, change);
    Eigen::VectorXd correction;
    if (model.pose_basis.cols() > 0) {
      const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> features = change;
      correction = model.pose_basis.middleCols<9>(9 * (joint - 1)) *
                   Eigen::Map<const Eigen::Matrix<double, 9, 1>>(features.data());
    }
    for (Eigen::Index n = 0; n < model.point_count(); ++n) {
      Vec3d sum = Vec3d::Zero();
      for (int j = 0; j < kJointCount; ++j) {
        const double weight = model.weights(n, j);
        if (weight == 0) continue;
        sum += weight * (moved.rotation[j] * corrected.segment<3>(3 * n) + moved.translation[j]);
        if (correction.size() > 0) sum += weight * (chain.rotation[j] * correction.segment<3>(3 * n));
      }
      out.block<3, 1>(3 * n, column) = sum;
    }
  }
  return out;
}

}  // namespace

LandmarkModel make_landmark_model(const HeadModel& model, std::span<const int> vertices) {
  LandmarkModel out;
  const Eigen::Index count = Eigen::Index(vertices.size());
  out.points.resize(3 * count);
  out.weights.resize(count, kJointCount);
  for (Eigen::Index n = 0; n < count; ++n) {
    LIKENESS_CHECK(vertices[n] >= 0 && vertices[n] < model.vertex_count(), "vertex %d of %d", vertices[n],
                   model.vertex_count());
    out.points.segment<3>(3 * n) = model.vertices[vertices[n]].cast<double>();
    out.weights.row(n) = model.skinning_weights.row(vertices[n]).cast<double>();
  }
  out.identity_basis = rows_of(model.identity_basis, vertices);
  out.expression_basis = rows_of(model.expression_basis, vertices);
  out.pose_basis = rows_of(model.pose_basis, vertices);
  const Eigen::Map<const Eigen::Matrix3Xf> all(model.vertices.front().data(), 3, model.vertex_count());
  const Eigen::Matrix<float, 3, kJointCount> joints = all * model.joint_regressor.transpose();
  out.joints = Eigen::Map<const Eigen::VectorXf>(joints.data(), 3 * kJointCount).cast<double>();
  out.joint_identity = regress_basis(model, model.identity_basis);
  out.joint_expression = regress_basis(model, model.expression_basis);
  out.parents = model.parents;
  return out;
}

std::vector<int> landmark_vertices(const HeadModel& model) {
  std::vector<int> vertices;
  for (const int triangle : model.landmark_triangle)
    for (int corner = 0; corner < 3; ++corner) vertices.push_back(model.triangles[triangle][corner]);
  return vertices;
}

std::vector<int> nearest_landmark_vertices(const HeadModel& model) {
  std::vector<int> vertices;
  for (int l = 0; l < kLandmarkCount; ++l) {
    int corner = 0;
    model.landmark_barycentric[l].maxCoeff(&corner);
    vertices.push_back(model.triangles[model.landmark_triangle[l]][corner]);
  }
  return vertices;
}

Eigen::Matrix3Xd combine_landmarks(const HeadModel& model, const Eigen::Matrix3Xd& positions) {
  LIKENESS_CHECK(positions.cols() == 3 * kLandmarkCount, "%d positions where %d are expected",
                 int(positions.cols()), 3 * kLandmarkCount);
  Eigen::Matrix3Xd landmarks(3, kLandmarkCount);
  for (int l = 0; l < kLandmarkCount; ++l)
    landmarks.col(l) = positions.middleCols<3>(3 * l) * model.landmark_barycentric[l].cast<double>();
  return landmarks;
}

LandmarkModel with_identity(const LandmarkModel& model, const Eigen::VectorXd& identity) {
  LIKENESS_CHECK(identity.size() <= model.identity_count(), "%d identity coefficients, the model has %d",
                 int(identity.size()), model.identity_count());
  LandmarkModel out = model;
  out.points = blend(model.points, model.identity_basis, identity);
  out.joints = blend(model.joints, model.joint_identity, identity);
  out.identity_basis.resize(model.identity_basis.rows(), 0);
  out.joint_identity.resize(model.joint_identity.rows(), 0);
  return out;
}

LandmarkPositions landmark_positions(const LandmarkModel& model, const Eigen::VectorXd& identity,
                                     const Eigen::VectorXd& expression,
                                     const JointRotations<double>& rotations, LandmarkDerivatives wanted) {
  LIKENESS_CHECK(identity.size() <= model.identity_count() && expression.size() <= model.expression_count(),
                 "%d identity and %d expression coefficients, the model has %d and %d", int(identity.size()),
                 int(expression.size()), model.identity_count(), model.expression_count());
  // -- Blend shapes
  Eigen::VectorXd points =
      blend(blend(model.points, model.identity_basis, identity), model.expression_basis, expression);
  const Eigen::VectorXd joint_row =
      blend(blend(model.joints, model.joint_identity, identity), model.joint_expression, expression);
  std::array<Vec3d, kJointCount> joints;
  for (int j = 0; j < kJointCount; ++j) joints[j] = joint_row.segment<3>(3 * j);

  // -- Pose
  PerJoint local;
  local[0].setIdentity();
  for (int j = 1; j < kJointCount; ++j) local[j] = rotation_from_vector<double>(rotations[j - 1]);
  if (model.pose_basis.cols() > 0) {
    Eigen::Matrix<double, kPoseFeatureCount, 1> features;
    for (int f = 0; f < kPoseFeatureCount; ++f)
      features[f] = local[f / 9 + 1](f % 9 / 3, f % 3) - (f % 9 % 4 == 0 ? 1.0 : 0.0);
    points += model.pose_basis * features;
  }
  const Chain chain = make_chain(model.parents, local);
  std::array<Vec3d, kJointCount> translation;
  for (int j = 0; j < kJointCount; ++j) {
    translation[j].setZero();
    for (int i = 0; i < kJointCount; ++i) translation[j] += chain.coupling[j][i] * joints[i];
  }

  // -- Skinning
  LandmarkPositions out;
  out.points.resize(3, model.point_count());
  for (Eigen::Index n = 0; n < model.point_count(); ++n) {
    Vec3d sum = Vec3d::Zero();
    for (int j = 0; j < kJointCount; ++j)
      if (model.weights(n, j) != 0)
        sum += model.weights(n, j) * (chain.rotation[j] * points.segment<3>(3 * n) + translation[j]);
    out.points.col(n) = sum;
  }

  // -- Derivatives
  if (wanted.identity)
    out.identity = coefficient_derivative(model, chain, model.identity_basis, model.joint_identity);
  if (wanted.expression)
    out.expression = coefficient_derivative(model, chain, model.expression_basis, model.joint_expression);
  if (wanted.rotation) out.rotation = rotation_derivatives(model, chain, rotations, joints, points);
  return out;
}

}  // namespace likeness
