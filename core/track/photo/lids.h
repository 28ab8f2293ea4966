// How far the lids are open, measured from the pixels: a landmark predictor loses closed eyes or follows them
// only in part, where the picture plainly shows whether an eyeball or skin lies between the lids.
//
// Each eye is looked at in a chart of its own, a paraboloid of the head frame over the eyeball, so that turns
// of the head are compensated. Three families of tones are learnt there from training frames, relative to the
// skin around the eye in the same picture: the eyeball's, the skin's, and the dark band of lashes along the
// upper margin. An opening cuts the chart into these families; the likelihood of the tones over all openings
// gives the frame's opening and its uncertainty. The eyeball's tones are learnt again from frames judged
// open. Finally the scale is made the person's own: 1 is the usual opening, 0 that of the fullest blinks of
// the clip, since with lashes a closed eye never looks quite empty.
#pragma once

#include <array>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/face/fit_frame.h"
#include "core/head/head_model.h"
#include "core/image/image.h"
#include "core/track/photo/gaze.h"

namespace likeness {

struct LidView {
  const Image8* grey = nullptr;  // working picture; null: the frame is left out
  Intrinsics intrinsics;         // of it
  Pose cam_from_head = Pose::Identity();
  std::array<Vec2d, kLandmarkCount> landmarks{};  // px of it
  bool held_out = false;
};

struct LidOpening {
  bool known = false;
  double opening = 1;      // height between the lids over this person's usual one
  double sigma = 1;        // of it, 1 standard deviation
  double corners_off = 0;  // how far the eye's landmarks are from its corners, widths of the eye
};
using LidOpenings = std::array<LidOpening, 2>;  // subject's right eye (landmarks 36..41), left (42..47)

struct LidReadings {
  std::vector<LidOpenings> frames;      // one a view
  std::array<double, 2> usual_gap_m{};  // height of the usual opening
};

// Deterministic. Shared quantities come from training views; a held-out view uses these and its own picture.
// Unknown if fewer than five training views show an eye. Fails only when stopped.
Result<LidReadings> read_lids(const EyeBalls& eyes, const std::vector<LidView>& views, std::stop_token stop);

// The opening as evidence for a frame's fit; landmarks of that eye get a larger sigma the further off they
// are.
void observe_lids(const LidOpenings& seen, const std::array<double, 2>& usual_gap_m, FaceObservation* out);

}  // namespace likeness
