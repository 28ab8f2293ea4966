// A head model restricted to a few vertices (the 68 landmarks, contour candidates), in double, so that
// fitting never touches the other thousands. Same meaning as pose_head.h, with derivatives.
//
//   s = template + B_id * identity + B_ex * expression        joints are linear in the same coefficients
//   p = sum_j w_j (R_j (s + B_pose * f) + t_j),  f = (R - I) of joints 1..4, row-major
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "core/head/head_model.h"

namespace likeness {

struct LandmarkModel {
  // Rows 3n+axis are point n, in the order asked for; rows 3j+axis joint j.
  Eigen::VectorXd points;            // (3N) m
  Eigen::MatrixXd identity_basis;    // (3N, I)
  Eigen::MatrixXd expression_basis;  // (3N, E)
  Eigen::MatrixXd pose_basis;        // (3N, 36) or no columns
  Eigen::MatrixXd weights;           // (N, 5) skinning
  Eigen::VectorXd joints;            // (15) m
  Eigen::MatrixXd joint_identity;    // (15, I)
  Eigen::MatrixXd joint_expression;  // (15, E)
  std::array<int, kJointCount> parents{-1, 0, 1, 1, 1};

  int point_count() const { return int(weights.rows()); }
  int identity_count() const { return int(identity_basis.cols()); }
  int expression_count() const { return int(expression_basis.cols()); }
};

// vertices: indices into the model, any order, repeats allowed.
LandmarkModel make_landmark_model(const HeadModel& model, std::span<const int> vertices);

// The vertices that carry the 68 landmarks: (204), three of each landmark's triangle in order, to be combined
// with model.landmark_barycentric (combine_landmarks below).
std::vector<int> landmark_vertices(const HeadModel& model);
Eigen::Matrix3Xd combine_landmarks(const HeadModel& model,
                                   const Eigen::Matrix3Xd& landmark_vertex_positions);  // (3, 68)
// For models whose landmarks are vertices (all barycentric weight on one corner): that vertex per landmark,
// so that 68 points do; else the corner of the greatest weight.
std::vector<int> nearest_landmark_vertices(const HeadModel& model);

// The same model with an identity baked in and no identity directions left: what a per-frame fit wants.
LandmarkModel with_identity(const LandmarkModel& model, const Eigen::VectorXd& identity);

// Rotation vectors of the joints below the root, rad: neck, jaw, left eye, right eye.
template <class T>
using JointRotations = std::array<Eigen::Matrix<T, 3, 1>, kJointCount - 1>;

// Positions, and their derivatives where asked for. Columns of `rotation`: 3 each of neck, jaw, left eye,
// right eye.
struct LandmarkPositions {
  Eigen::Matrix3Xd points;     // (3, N) m, head frame
  Eigen::MatrixXd identity;    // (3N, I) d point / d coefficient
  Eigen::MatrixXd expression;  // (3N, E)
  Eigen::MatrixXd rotation;    // (3N, 12) m per rad
};
struct LandmarkDerivatives {
  bool identity = false, expression = false, rotation = false;
};

// identity, expression: at most the model's count; missing ones are zero. For 68 points and 150 coefficients
// about 0.03 ms, with all derivatives 0.15 ms.
LandmarkPositions landmark_positions(const LandmarkModel& model, const Eigen::VectorXd& identity,
                                     const Eigen::VectorXd& expression,
                                     const JointRotations<double>& rotations,
                                     LandmarkDerivatives wanted = {});

// Rodrigues' formula; smooth through zero, for any scalar with sqrt, sin and cos.
template <class T>
Eigen::Matrix<T, 3, 3> rotation_from_vector(const Eigen::Matrix<T, 3, 1>& r) {
  using std::cos, std::sin, std::sqrt;
  const T squared = r.squaredNorm();
  T a, b;  // sin(t) / t and (1 - cos(t)) / t^2
  if (squared < T(1e-12)) {
    a = T(1) - squared / T(6);
    b = T(0.5) - squared / T(24);
  } else {
    const T angle = sqrt(squared);
    a = sin(angle) / angle;
    b = (T(1) - cos(angle)) / squared;
  }
  Eigen::Matrix<T, 3, 3> k;
  k << T(0), -r.z(), r.y(), r.z(), T(0), -r.x(), -r.y(), r.x(), T(0);
  return Eigen::Matrix<T, 3, 3>::Identity() + k * a + (k * k) * b;
}

// The positions for automatic differentiation: T may be a Ceres Jet. identity and expression point to the
// model's counts of coefficients.
template <class T>
Eigen::Matrix<T, 3, Eigen::Dynamic> landmark_positions_of(const LandmarkModel& model, const T* identity,
                                                          const T* expression,
                                                          const JointRotations<T>& rotations);

}  // namespace likeness

#include "core/head/landmark_model_inl.h"  // IWYU pragma: export
