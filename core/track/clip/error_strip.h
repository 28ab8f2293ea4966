// A picture of a whole track at a glance: every frame's landmark error, spread and verdict side by side.
#pragma once

#include "core/image/image.h"
#include "core/scene/track.h"

namespace likeness {

// One column a frame, several px wide in short clips: two rows of bars in px of the source with labelled axes
// (how far the head model misses the landmarks; how far the landmark runs disagree), and a row in the
// verdict's colour: green good, amber weak, red lost. (h, w, 3) sRGB.
Image8 error_strip(const Track& track);

// Mean spread of the landmarks 17..67, px of the source.
double mean_inner_spread(const TrackedFrame& frame);

}  // namespace likeness
