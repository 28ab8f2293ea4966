// An avatar's poses and cameras, picture by picture.
#pragma once

#include <vector>

#include "core/camera/camera.h"
#include "core/scene/avatar_pose.h"

namespace likeness {

struct Film {
  std::vector<Camera> cameras;    // of one picture size
  std::vector<AvatarPose> poses;  // one a camera
};

}  // namespace likeness
