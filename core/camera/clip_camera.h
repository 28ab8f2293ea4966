// The camera of a clip that has no solve of its own.
#pragma once

#include "core/camera/camera.h"
#include "core/video/decode.h"

namespace likeness {

// One camera at rest for the whole clip, with the focal length that its file tells, or a usual one: for when
// it matters what the head does, not where the camera is.
CameraSet assumed_camera(const VideoInfo& info);

}  // namespace likeness
