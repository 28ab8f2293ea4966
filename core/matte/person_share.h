// How the tracked prior takes up what a person network says of a picture (core/matte/person_network.h): the
// network decides where its outline is far, and leaves to colours, plate and neighbours in time what is near.
// Shares are 8U, 0..255 for 0..1, at the prior's size.
#pragma once

#include <opencv2/core.hpp>

#include "core/matte/person_prior.h"

namespace likeness {

// The median of three pictures in a row: what flickers in one of them alone is gone, while an outline that
// moves on, and so passes each pixel once, stays where it is.
cv::Mat steady_share(const cv::Mat& before, const cv::Mat& own, const cv::Mat& after);

// The share of the person that `seed` (8U, not 0) lies in: other people become 0, and holes of at most
// `hole_px` across are closed. Empty if the network does not see the better part of the seed as a person:
// then it failed in this picture and says nothing.
cv::Mat persons_own_share(const cv::Mat& share, const cv::Mat& seed, double hole_px);

// Widths, in px, of the band about the network's outline in which it is not certain.
struct ShareBand {
  double edge = 3;                           // on both sides, of skin and clothes
  double hair_outside = 8, hair_inside = 4;  // where hair may be: strands leave the outline, gaps enter it
};
ShareBand share_band(double px_per_metre);

// Takes up the share in the tracked prior: deep inside the outline is certain, far outside is excluded, and
// between the two its log-odds are the place's evidence. A failed share (see above) changes nothing. Strokes
// come after it.
void take_up_share(PersonPrior& prior, const cv::Mat& share, const ShareBand& band, double hole_px);

}  // namespace likeness
