// Dense poses that the landmarks contradict. Points on a head say how it moves better than any landmark - but
// not those on hair that swings, on a film of few pixels or of smeared ones, and then a pose wanders off the
// face. Landmarks have errors, but none that moves all of them one way by so much.
#pragma once

#include "core/track/clip/clip_work.h"

namespace likeness {

// Gives up the poses of frames whose face lies beside all landmarks by 3 % of the distance between the eyes'
// outer corners, and all of the clip's where that is 0.8 % in the median of the training frames. Returns
// whether there were any; the faces then have to be fitted again.
bool drop_wandering_poses(ClipWork& work);

}  // namespace likeness
