// A person's resting face, from their track. Landmark fits leave a constant of the person's looks in the
// expression (a low brow reads as a frown); driving, sliders and gains count from here instead of from zero.
#pragma once

#include <set>
#include <span>

#include "core/head/head_model.h"
#include "core/scene/track.h"

namespace likeness {

// Expression and jaw: the median over the frames of `rest`, times its trust, since what else is known of a
// resting face is that it is the head model's own. Where it names no frame, the mode of each coefficient over
// the frames that may show the rest: they weigh less the more the lower face moves within 0.2 s (speech), the
// wider the mouth is open and the more the lids are shut. Eyes count by these weights, too, and where the
// head has its typical direction. Held-out, lost and weak frames take no part, as long as 10 others remain.
// Zero if there is no frame at all.
Articulation calibrate_neutral(const HeadModel& model, std::span<const TrackedFrame> frames,
                               const std::set<int>& held_out, const RestChoice& rest = {});

}  // namespace likeness
