// What a user would have painted who went by the track: where mouth and eyes are on a few frames, and how
// far open, as CoNeRF's captures are annotated (Kania et al. 2022: on about a twentieth of the frames). So
// that a model which knows painted attributes alone can be compared on captures that nobody painted on.
#pragma once

#include "core/capture/capture.h"
#include "core/matte/attributes.h"
#include "core/train/train.h"

namespace likeness {

// Of the set's own views, `share` of them for each attribute, six at least, from the least to the most that
// the track shows. An attribute that hardly changes is left out, so there may be none.
PaintedAttributes annotate_from_track(const TrainingSet& set, const Capture& capture, double share = 0.05);

}  // namespace likeness
