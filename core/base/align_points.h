// Motions that bring points or directions onto others. Eigen's routines, compiled here once, as in
// core/base/dense_solves.h.
#pragma once

#include "core/base/linalg.h"

namespace likeness {

// The similarity (scale, rotation, translation) that maps `from` nearest to `to` in the least-squares sense
// (Umeyama, TPAMI 1991), as a homogeneous matrix. (3, n) each, n >= 3; not finite where all points are one.
Eigen::Matrix4d similarity_between(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

// The smallest rotation that turns one direction into another; neither needs length 1, neither is zero.
Mat3d rotation_between(const Vec3d& from, const Vec3d& to);

// The eigenvector of a symmetric matrix's largest eigenvalue, of length 1; its sign is arbitrary.
Eigen::Vector4d principal_axis(const Eigen::Matrix4d& a);

}  // namespace likeness
