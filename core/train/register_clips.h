// Registering further clips to the head frame of the first one. Each clip's track says how its head moves,
// but where in that head the face lies comes only from its landmarks, which differ between clips by a
// millimetre or two. The field learnt from the first clip measures that difference.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "core/render/pose_avatar.h"
#include "core/train/train.h"

namespace likeness {

struct RegisterOptions {
  int views = 16;     // of each clip, spread evenly
  int pixels = 1024;  // of each view
  int iterations = 5;
  double largest_turn = 0.15, largest_shift = 0.03;  // rad, m: beyond it the views cannot be trusted
  std::uint64_t seed = 0;
};

// Corrections of all views (core/train/refine_track.h), kPoseChange numbers each: zeros for the first clip's,
// and for those of a further clip one motion of the head frame that its views share, the median of their
// individual fits to the frozen field, after mapping their colours to the avatar's light. avatar: learnt from
// the first clip only. Empty if stopped.
std::vector<Eigen::VectorXd> register_clips(const TrainingSet& set, const Avatar& avatar,
                                            const AvatarRig& rig, const RegisterOptions& options,
                                            std::stop_token stop);

}  // namespace likeness
