// Which frames of a clip show the person's face at rest: the calmest with a closed mouth. A person who smiles
// through most of a clip does not rest in its mean.
//
// Each frame weighs the less, the more the mouth moves around it, the further its lips are apart, the less
// ordinary the lids, the higher the brows, and the more the head is turned away. The rest is then the frame i
// of the largest
//   log p(width, lift) + log(n / (n + n0)),   n = sum_j w_j K(i, j)
// with the mean width and corners of the frames like it; n0 of them make a rest certain. p is what closed
// mouths at rest look like: among people (usual_mouth), and in someone whose narrowest and widest mouth this
// clip shows, since a smile or a pucker changes a mouth's width by a quarter or so. It decides between a
// smile held for long, which is wide with high corners, and a short rest, or between a rest and a pucker. K
// is a Gaussian in width, corners and brows.
#pragma once

#include <span>
#include <vector>

#include "core/scene/track.h"
#include "core/track/fit/face_measures.h"

namespace likeness {

struct RestFrame {
  int frame = 0;  // number in the source
  double time_s = 0;
  bool usable = false;  // a training frame whose landmarks are believed
  FaceMeasures face;
  bool lids_known = false;
  double lids = 1;  // how far they are open, 1 = usual, by the pixels
};

struct RestOptions {
  int fewest = 5;       // frames; and at least hold_s of a film
  double hold_s = 0.3;  // shorter: passed through rather than rested
  int most = 30;        // the calmest of those alike
};

// frames: ascending. asked: frames that the user names instead, of which those usable are taken. Without a
// usable frame the choice is empty. Where the clip has no calm closed mouth that people would call at rest,
// the nearest to it, with a warning and a trust below 1.
RestChoice choose_rest(std::span<const RestFrame> frames, const UsualMouth& usual, std::span<const int> asked,
                       const RestOptions& options = {});

}  // namespace likeness
