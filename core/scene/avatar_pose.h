// Where a person or an avatar is and what the face does: the pose shared by tracks, training, performances
// and pictures.
#pragma once

#include <vector>

#include "core/base/linalg.h"
#include "core/head/head_model.h"
#include "core/scene/torso_warp.h"

namespace likeness {

struct AvatarPose {
  Pose world_from_head = Pose::Identity();   // m
  Pose world_from_torso = Pose::Identity();  // m; the torso frame is the head frame of the reference frame
  Articulation articulation;
  TorsoShape torso_shape{};         // of the torso's modes
  std::vector<float> attributes{};  // amounts, in the avatar's or the set's order; empty: all at rest
  // Scores of this frame's own detail map; empty: predicted from the articulation.
  Eigen::VectorXf detail{};
};

}  // namespace likeness
