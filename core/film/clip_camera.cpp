// A camera at rest: see clip_camera.h.
#include "core/film/clip_camera.h"

#include <algorithm>

#include "core/camera/align.h"

namespace likeness {

CameraSet assumed_camera(const VideoInfo& info) {
  const double focal = AlignOptions{}.focal_over_width * info.width;
  CameraSet set;
  set.cameras = {Camera{-1, {info.width, info.height, focal, focal, info.width / 2.0, info.height / 2.0}}};
  return set;
}

}  // namespace likeness
