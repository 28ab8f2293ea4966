// Rigid motions: inverses of poses, and rotations from and to an axis and an angle. Eigen's routines,
// compiled here once, as in core/base/dense_solves.h.
#pragma once

#include "core/base/linalg.h"

namespace likeness {

// b_from_a of a_from_b.
Pose inverse(const Pose& pose);

// The rotation about an axis of length 1 by an angle in rad, counter-clockwise seen from the tip of the axis.
Mat3d rotation_about(const Vec3d& axis, double angle);

// The axis, of length 1, and the angle of a rotation, 0..pi rad. The axis is x where the angle is 0, and its
// sign is arbitrary where it is pi.
Eigen::AngleAxisd axis_and_angle(const Mat3d& rotation);

// How far a rotation turns, 0..pi rad.
double rotation_angle(const Mat3d& rotation);

// Rotation vectors: the axis times the angle, rad.
Mat3d turn_from_vector(const Vec3d& rotation_vector);
Vec3d vector_from_turn(const Mat3d& turn);

// The matrix that maps x to v cross x: to first order in v, turn_from_vector(v) - I.
inline Mat3d cross_matrix(const Vec3d& v) {
  Mat3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace likeness
