// The built-in head seen by a synthetic camera: landmarks with known pose, expression and identity.
#pragma once

#include <random>

#include "core/base/rigid.h"
#include "core/face/fit_frame.h"
#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"

namespace likeness {

inline const HeadModel& test_head() {
  static const HeadModel model = make_builtin_head();
  return model;
}

// Without identity.
inline const HeadShape& test_shape() {
  static const HeadShape shape = shape_head(test_head(), Eigen::VectorXf());
  return shape;
}

inline const Eigen::VectorXf& test_identity() {
  static const Eigen::VectorXf identity = [] {
    Eigen::VectorXf some = Eigen::VectorXf::Zero(test_head().identity_count());
    for (int i = 0; i < 6; ++i) some[i] = i % 2 == 0 ? 0.6f : -0.5f;
    return some;
  }();
  return identity;
}

inline const ReducedHead& test_reduced_head() {
  static const ReducedHead head = reduce_head(test_head(), 20);
  return head;
}

inline Pose facing_pose(double yaw, double pitch, const Vec3d& translation) {
  Pose pose = Pose::Identity();
  const Mat3d facing = Vec3d(1, -1, -1).asDiagonal();
  pose.linear() = facing * rotation_about(Vec3d::UnitY(), yaw) * rotation_about(Vec3d::UnitX(), pitch);
  pose.translation() = translation;
  return pose;
}

// Landmarks of a state with Gaussian noise; jaw landmarks where the silhouette is.
inline FaceObservation observe_state(const ReducedHead& head, const ReducedPerson& person,
                                     const FaceState& state, double noise_px, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  FaceObservation o;
  o.focal_px = 1000;
  o.sigma_px.fill(1.0);
  for (int i = 0; i < kLandmarkCount; ++i) {
    const Vec3d p = state.cam_from_head * reduced_point(head, person, i, state.expression, state.jaw);
    o.rays[i] = p.hnormalized() + Vec2d(normal(random), normal(random)) * noise_px / o.focal_px;
  }
  return o;
}

}  // namespace likeness
