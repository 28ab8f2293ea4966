// A camera at rest: see clip_camera.h.
#include "core/camera/clip_camera.h"

#include "core/camera/assumed_lens.h"

namespace likeness {

CameraSet assumed_camera(const VideoInfo& info) {
  CameraSet set;
  set.cameras = {Camera{-1, assumed_intrinsics(info.width, info.height, info.focal_35mm)}};
  return set;
}

}  // namespace likeness
