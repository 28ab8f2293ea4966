// A frame of a driven avatar.
#pragma once

#include "core/scene/avatar_pose.h"

namespace likeness {

struct DrivenFrame {
  int frame = 0;
  double time_s = 0;
  bool bridged = false;  // the driver was lost here
  AvatarPose pose;       // in the avatar's world, of the avatar's head model; attributes at rest
};

}  // namespace likeness
