// A frame's pose and expression fitted to the frozen field. Two uses: the trainer corrects its training
// frames' tracks (off by default), and eval uses it as an oracle, under its own name, for what better
// tracking of the held-out frames could still gain.
#pragma once

#include <cstdint>

#include "core/image/image.h"
#include "core/render/pose_avatar.h"

namespace likeness {

inline constexpr int kPoseChange = 6;  // turn about the head's origin (world axes, rad), shift (m)

// A change of a tracked pose: kPoseChange numbers, then components of the condition (psi). An empty one
// changes nothing.
AvatarPose changed_pose(const AvatarPose& tracked, const ConditionMap& map, const Eigen::VectorXd& change);

struct FieldFitOptions {
  int pixels = 4096;   // drawn from the region; the cost is proportional
  int iterations = 8;  // Gauss-Newton steps, 25 renderings of the pixels each
  int components = 6;  // of the condition; 0: only the pose, at half the cost
  std::uint64_t seed = 0;
};

struct FieldFit {
  Eigen::VectorXd change;                // from the tracked pose
  double mse_before = 0, mse_after = 0;  // over the pixels drawn
};

// The frame's picture, plate and region, all of the camera's size.
struct FieldTarget {
  const Image8* rgb = nullptr;     // (h, w, 3)
  const Image8* plate = nullptr;   // (h, w, 3) its background, or empty: white
  const Image8* region = nullptr;  // (h, w, 1) 255 where pixels may be drawn
};

// start: an earlier change, or empty. Regularised towards the tracked pose; the torso stays as tracked.
FieldFit fit_to_field(const Avatar& avatar, const AvatarRig& rig, const Camera& camera,
                      const FieldTarget& target, const AvatarPose& tracked, const Eigen::VectorXd& start,
                      const FieldFitOptions& options);

}  // namespace likeness
