// The vector and matrix types of every public header: Eigen's, under short names.
// Poses are rigid and in double precision; mesh data is float.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace likeness {

using Vec2f = Eigen::Vector2f;
using Vec3f = Eigen::Vector3f;
using Vec2d = Eigen::Vector2d;
using Vec3d = Eigen::Vector3d;
using Mat3d = Eigen::Matrix3d;
using Triangle = Eigen::Vector3i;  // vertex indices, counter-clockwise seen from outside

// Rigid transform, named right to left: world_from_head * point_in_head is a point in the world.
using Pose = Eigen::Isometry3d;

}  // namespace likeness
