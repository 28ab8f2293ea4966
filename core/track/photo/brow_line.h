// Locating the brows in the picture. The landmark predictor loses brows that are raised high: its points fall
// onto the crease of the lids, further down than at rest, and agree with each other there. Dark brows on dark
// skin it places up to a centimetre too high or low, depending on the head's turn. The person's own resting
// brows, cut from training frames in head coordinates, are slid along the forehead instead; where they are
// clearly not at the predictor's points, these are moved.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/face/fit_clip.h"
#include "core/image/image.h"

namespace likeness {

struct BrowPicture {
  const Image8* grey = nullptr;  // working picture; null: leave the frame alone
  Intrinsics intrinsics;         // of the working picture
};

struct BrowSummary {
  bool known = false;  // the resting brows stand out enough to be found again
  int corrected = 0;   // halves of a brow
};

// pictures: one for each of `faces`, of which those with a given pose take part; their observations of points
// 17..26 are corrected in place. person: at rest. Held-out frames are corrected, but nothing is learnt from
// them.
Result<BrowSummary> correct_brows(const ReducedHead& head, const ReducedPerson& person,
                                  const std::vector<BrowPicture>& pictures, std::vector<FaceFrame>& faces,
                                  std::stop_token stop);

}  // namespace likeness
