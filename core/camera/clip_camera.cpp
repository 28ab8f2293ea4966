// A camera at rest: see clip_camera.h.
#include "core/camera/clip_camera.h"

#include "core/camera/assumed_lens.h"

namespace likeness {

CameraSet assumed_camera(const VideoInfo& info, const PixelRect& film) {
  CameraSet set;
  if (film.empty()) {
    set.cameras = {Camera{-1, assumed_intrinsics(info.width, info.height, info.focal_35mm)}};
    return set;
  }
  Intrinsics lens = assumed_intrinsics(film.width, film.height, info.focal_35mm);
  lens.cx += film.x, lens.cy += film.y;
  lens.width = info.width, lens.height = info.height;
  set.cameras = {Camera{-1, lens}};
  return set;
}

}  // namespace likeness
