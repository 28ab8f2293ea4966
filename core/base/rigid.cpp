#include "core/base/rigid.h"

namespace likeness {

Pose inverse(const Pose& pose) { return pose.inverse(); }

Mat3d rotation_about(const Vec3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

Eigen::AngleAxisd axis_and_angle(const Mat3d& rotation) { return Eigen::AngleAxisd(rotation); }

double rotation_angle(const Mat3d& rotation) { return Eigen::AngleAxisd(rotation).angle(); }

Mat3d turn_from_vector(const Vec3d& v) {
  const double angle = v.norm();
  return angle < 1e-12 ? Mat3d(Mat3d::Identity() + cross_matrix(v))
                       : Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

Vec3d vector_from_turn(const Mat3d& turn) {
  const Eigen::AngleAxisd a(turn);
  return a.angle() * a.axis();
}

}  // namespace likeness
