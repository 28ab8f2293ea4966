// Which stretch of a tracked clip is fitted again, and how far around it is looked (refit_span.h).
#pragma once

#include "core/track/track_options.h"

namespace likeness {

// Frames first..last (numbers in the source).
struct RefitSpan {
  int first = 0, last = 0;
  bool operator==(const RefitSpan&) const = default;
};

struct RefitOptions {
  TrackOptions track;  // working size, predictor and frames, as the track was made
  int margin = 12;     // frames beyond the anchors that show how the face looks; reading them takes time
  int reach = 48;      // frames to the nearest anchor; followed points drift beyond
  int runs = 32;       // of the landmark predictor, a millisecond each
};

}  // namespace likeness
