// The template body of landmark_model.h.
#pragma once

#include "core/head/landmark_model.h"

namespace likeness {

template <class T>
Eigen::Matrix<T, 3, Eigen::Dynamic> landmark_positions_of(const LandmarkModel& model, const T* identity,
                                                          const T* expression,
                                                          const JointRotations<T>& rotations) {
  using Vec = Eigen::Matrix<T, 3, 1>;
  using Mat = Eigen::Matrix<T, 3, 3>;
  // row of base + B_id * identity + B_ex * expression; loops, as Eigen's products do not mix scalars.
  const auto blend = [&](const Eigen::VectorXd& base, const Eigen::MatrixXd& by_identity,
                         const Eigen::MatrixXd& by_expression, int first_row) {
    Vec sum;
    for (int axis = 0; axis < 3; ++axis) {
      T value(base[first_row + axis]);
      for (Eigen::Index c = 0; c < by_identity.cols(); ++c)
        value += identity[c] * by_identity(first_row + axis, c);
      for (Eigen::Index c = 0; c < by_expression.cols(); ++c)
        value += expression[c] * by_expression(first_row + axis, c);
      sum[axis] = value;
    }
    return sum;
  };

  // -- Skeleton
  std::array<Mat, kJointCount> local, rotation;
  std::array<Vec, kJointCount> joint, position, translation;
  for (int j = 0; j < kJointCount; ++j) {
    joint[j] = blend(model.joints, model.joint_identity, model.joint_expression, 3 * j);
    local[j] = j == 0 ? Mat(Mat::Identity()) : rotation_from_vector<T>(rotations[j - 1]);
    const int parent = model.parents[j];
    rotation[j] = parent < 0 ? local[j] : Mat(rotation[parent] * local[j]);
    position[j] =
        parent < 0 ? joint[j] : Vec(position[parent] + rotation[parent] * (joint[j] - joint[parent]));
    translation[j] = position[j] - rotation[j] * joint[j];
  }

  // -- Points
  Eigen::Matrix<T, 3, Eigen::Dynamic> points(3, model.point_count());
  for (int n = 0; n < model.point_count(); ++n) {
    Vec point = blend(model.points, model.identity_basis, model.expression_basis, 3 * n);
    for (Eigen::Index f = 0; f < model.pose_basis.cols(); ++f) {
      const int entry = int(f) % 9;
      const T feature = local[f / 9 + 1](entry / 3, entry % 3) - T(entry % 4 == 0 ? 1 : 0);
      for (int axis = 0; axis < 3; ++axis) {
        const double direction = model.pose_basis(3 * n + axis, f);
        if (direction != 0) point[axis] += feature * direction;
      }
    }
    Vec posed = Vec::Zero();
    for (int j = 0; j < kJointCount; ++j) {
      const double weight = model.weights(n, j);
      if (weight != 0) posed += (rotation[j] * point + translation[j]) * T(weight);
    }
    points.col(n) = posed;
  }
  return points;
}

}  // namespace likeness
