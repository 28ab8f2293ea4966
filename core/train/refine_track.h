// Training frames' tracks corrected through the field learnt so far: each frame's pose, and a little of its
// expression, moves to where the frozen field explains the picture best. Corrections are pulled towards the
// track, bounded, and have zero mean over the frames, so that the head does not drift as a whole.
#pragma once

#include <stop_token>
#include <vector>

#include "core/train/field_fit.h"
#include "core/train/train.h"

namespace likeness {

struct RefineOptions {
  int pixels = 1024;  // of each frame
  int components = 6;
  double largest_turn = 0.02, largest_shift = 0.004, largest_component = 0.3;  // rad, m, psi
  std::uint64_t seed = 0;
};

// (size, size, 1), 255: the box of the head's posed landmarks, half as large again.
Image8 head_box(const TrainingView& view, const AvatarRig& rig);

// Poses of the set's views with their corrections; empty if `corrections` is empty.
std::vector<AvatarPose> corrected_poses(const TrainingSet& set, const ConditionMap& map,
                                        const std::vector<Eigen::VectorXd>& corrections);
// The same, and behind them the proxies' poses, which nothing corrects.
std::vector<AvatarPose> pictured_poses(const TrainingSet& set, const ConditionMap& map,
                                       const std::vector<Eigen::VectorXd>& corrections);

// One Gauss-Newton step of every view of the avatar's own clip from its earlier correction; about 0.3 s a
// view on one core. If stopped, the corrections stay as they were; those of further clips' views always do.
std::vector<Eigen::VectorXd> refine_track(const TrainingSet& set, const Avatar& avatar, const AvatarRig& rig,
                                          const std::vector<Eigen::VectorXd>& corrections,
                                          const RefineOptions& options, std::stop_token stop);

}  // namespace likeness
