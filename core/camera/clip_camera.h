// The camera of a clip that has no solve of its own.
#pragma once

#include "core/camera/camera.h"
#include "core/image/pixel_rect.h"
#include "core/video/decode.h"

namespace likeness {

// film: what was filmed of the clip's pictures (AlignOptions::film); empty: all of them.
//
// One camera at rest for the whole clip, with the focal length recorded in its file, or a usual one: for uses
// where the head's motion matters, not the camera's place.
CameraSet assumed_camera(const VideoInfo& info, const PixelRect& film = {});

}  // namespace likeness
