// The surroundings of a face, cut out of a picture: what its landmarks are looked for in once the picture
// itself is gone.
#pragma once

#include <optional>

#include "core/face/face_landmarks.h"
#include "core/face/landmarks.h"
#include "core/image/image.h"

namespace likeness {

struct FacePatch {
  Image8 luma;
  double x = 0, y = 0, scale = 1;  // px of the picture = x + px of the patch * scale
  FaceBox face;                    // px of the patch
};

// Reduced where the face is larger than landmarks need.
FacePatch cut_face_patch(const Image8& picture, const FaceBox& face);

// Px of the picture that the patch was cut from; nullopt where they are too unsure to say where a head is.
std::optional<Landmarks> patch_landmarks(const FaceDetector& detector, const FacePatch& patch);

}  // namespace likeness
