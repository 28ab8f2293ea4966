// Between landmarks in a picture and a fit: pixels to rays, and back from a fitted pose to where the next
// landmarks are expected.
#pragma once

#include "core/camera/camera.h"
#include "core/face/fit_frame.h"
#include "core/face/landmarks.h"

namespace likeness {

// source: the camera of the picture in whose pixels the landmarks are; scale: working px per source px;
// focal_px: of the working picture. Lids and lips are those of `before`.
FaceObservation observe_face(const Landmarks& landmarks, const Intrinsics& source, double scale,
                             double focal_px, FaceObservation before = {});

// Where a head of this pose shows its landmarks, at a neutral face; px of the intrinsics' picture.
struct ExpectedFace {
  FaceBox box;  // as the predictor expects its start box
  LandmarkHint hint;
};
ExpectedFace expect_face(const ReducedHead& head, const ReducedPerson& person, const Intrinsics& intrinsics,
                         const Pose& cam_from_head);

}  // namespace likeness
