#include "core/track/nearest_rotation.h"

#include <Eigen/SVD>

namespace likeness {

Mat3d nearest_rotation(const Mat3d& m) {
  const Eigen::JacobiSVD<Mat3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Vec3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

}  // namespace likeness
