// Marks the frames that a split holds out: fixed by the source's time before any frame is refused, so that
// the split stays the same whatever is refused later.
#pragma once

#include <vector>

#include "core/capture/capture.h"

namespace likeness {

// Each marks frames as held out, at least one unless `share` is 0, and all others as not.

// The last `share` of the frames.
void hold_out_tail(std::vector<CaptureFrame>& frames, double share);
// A run of `share` of the frames within `moving`, in its middle: views between those that train.
void hold_out_views(std::vector<CaptureFrame>& frames, const FrameSpan& moving, double share);
// The last `share` of the frames that see the head from within sides.inside_deg, and all that see it from
// farther than sides.beyond_deg. Those that do neither, and those whose view is not known, are marked as kept
// apart, with the reason in `refused`. By their views (core/capture/head_views.h).
void hold_out_sides(std::vector<CaptureFrame>& frames, const SideRange& sides, double share);
// `share` of the frames, spread at random: the same ones for any two clips of equal length.
void hold_out_random(std::vector<CaptureFrame>& frames, double share);

}  // namespace likeness
