// Poses and expressions of a face in pictures too far apart to support each other, such as a few a second of
// a clip: a head model fitted to their landmarks.
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/face/face_landmarks.h"
#include "core/face/fit_frame.h"
#include "core/head/head_model.h"

namespace likeness {

struct LandmarkLook {
  int frame = 0;  // number in the source
  Landmarks landmarks;
};

// One identity for all of them, and a state for each, in their order; none where there are fewer than three.
// lens: of the pictures that the landmarks lie in.
Result<std::vector<FaceState>> fit_looks(const HeadModel& model, const Intrinsics& lens,
                                         std::span<const LandmarkLook> looks, const Progress& progress,
                                         std::stop_token stop);

// The direction from the head to the camera, of length 1 in the head's frame; not finite where there is none.
Vec3d direction_to_camera(const FaceState& state);

}  // namespace likeness
