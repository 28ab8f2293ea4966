#include "core/base/mean_rotation.h"

#include <Eigen/SVD>
#include <cmath>

#include "core/base/rigid.h"

namespace likeness {

Mat3d nearest_rotation(const Mat3d& m) {
  const Eigen::JacobiSVD<Mat3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Vec3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

Mat3d mean_rotation(std::span<const Mat3d> rotations) {
  if (rotations.empty()) return Mat3d::Identity();
  Mat3d sum = Mat3d::Zero();
  for (const Mat3d& rotation : rotations) sum += rotation;
  return nearest_rotation(sum);
}

double turn_about_mean(std::span<const Mat3d> rotations) {
  const Mat3d mean = mean_rotation(rotations);
  double squared = 0;
  for (const Mat3d& rotation : rotations) {
    const double angle = rotation_angle(rotation * mean.transpose());
    squared += angle * angle;
  }
  return rotations.empty() ? 0 : std::sqrt(squared / double(rotations.size()));
}

}  // namespace likeness
