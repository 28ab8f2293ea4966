// How widely a capture's mouth was seen to smile, whatever the track's coefficients make of it: by the width
// between its corners, in the person's own at rest, and by teeth. A smile that went into the resting face, or
// into the head's shape, is still one.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/head/head_model.h"
#include "core/image/image.h"
#include "core/scene/track.h"

namespace likeness {

struct SeenMouth {
  // 98th percentile of the training frames' width over that at rest, of those in which the corners are
  // raised; 1: none are.
  double widest = 1;
  double smile = 0;    // the amount of both smiling actions that widens a mouth at rest as much, 1 = full
  bool teeth = false;  // seen between the lips of mouths that are wide with raised corners
};

// The capture's own picture of a frame (RGB, crop, capture.size), or nothing.
using FramePictures = std::function<std::optional<Image8>(int frame)>;

// pictures: asked for a few of the widest mouths only.
SeenMouth seen_mouth(const Capture& capture, const CameraSet& cameras, const Track& track,
                     const HeadModel& model, const FramePictures& pictures);

// With the pictures of a project's folder.
SeenMouth seen_mouth(const std::filesystem::path& folder, const Capture& capture, const CameraSet& cameras,
                     const Track& track, const HeadModel& model);

// The share of the area between the lips that shows teeth: about as bright as the skin around, and far less
// saturated. landmarks: of the picture, px.
double teeth_share(const Image8& rgb, const std::array<Vec2d, kLandmarkCount>& landmarks);

}  // namespace likeness
