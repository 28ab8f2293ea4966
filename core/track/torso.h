// Where the torso is: direct alignment of the picture below the chin to a reference frame, as a small rigid
// motion of a body-shaped surface at the neck's depth.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/image/image.h"

namespace likeness {

struct TorsoFrame {
  const Image8* grey = nullptr;  // working picture, one channel
  bool usable = false;           // head pose and camera known
  bool held_out = false;
  Intrinsics intrinsics;                   // of the working picture
  Pose cam_from_world = Pose::Identity();  // metric
  Pose world_from_head = Pose::Identity();
};

struct TorsoTrack {
  bool has_torso = false;
  int reference = -1;                  // index of the frame whose head frame is the torso frame
  std::vector<Pose> world_from_torso;  // one a frame
  double residual_before = 0,
         residual_after = 0;  // mean grey-level difference to the reference, unmoved and moved
};

// chin: of the person, head frame, m.
Result<TorsoTrack> track_torso(const std::vector<TorsoFrame>& frames, const Vec3d& chin,
                               const Progress& progress, std::stop_token stop);

}  // namespace likeness
