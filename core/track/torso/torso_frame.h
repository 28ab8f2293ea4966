// What is known of a frame before its torso is.
#pragma once

#include "core/camera/camera.h"
#include "core/image/image.h"
#include "core/track/torso/convex_outline.h"

namespace likeness {

struct TorsoFrame {
  const Image8* grey = nullptr;  // working picture, one channel
  bool usable = false;           // head pose and camera known
  bool held_out = false;
  int shot = 0;                            // frames of different ones are no neighbours
  Intrinsics intrinsics;                   // of the working picture
  Pose cam_from_world = Pose::Identity();  // metric
  Pose world_from_head = Pose::Identity();
  ConvexOutline head_outline;  // px of the working picture: hides the torso; empty = unknown
};

}  // namespace likeness
