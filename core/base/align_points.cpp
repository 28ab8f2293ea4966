#include "core/base/align_points.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace likeness {

Eigen::Matrix4d similarity_between(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  return Eigen::umeyama(from, to, true);
}

Mat3d rotation_between(const Vec3d& from, const Vec3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

Eigen::Vector4d principal_axis(const Eigen::Matrix4d& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(a);
  return solver.eigenvectors().col(3);
}

}  // namespace likeness
