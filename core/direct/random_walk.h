// A random performance: the head looks about, the face does a little of this and that, all within what the
// capture showed. For trying an avatar, and for previews.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/direct/performance.h"
#include "core/direct/seen_limits.h"

namespace likeness {

struct WalkOptions {
  std::uint64_t seed = 0;
  double duration_s = 10;
  double frames_per_second = 25;
  double pace_s = 1.2;    // between changes, on average
  float strength = 0.7f;  // share of the seen range, 0..1
};

// Smooth keys in every channel of `limits` except the camera's; begins and ends at rest, so that it can be
// repeated. Both sides of the face do the same, as far as both were seen to. The same seed gives the same
// walk everywhere.
Performance random_walk(const std::map<std::string, ValueRange>& limits, const WalkOptions& options);

// Replaces what head and face do over the whole performance by the walk; its length and the camera stay.
void set_walk(Performance& performance, const std::map<std::string, ValueRange>& limits, std::uint64_t seed);

}  // namespace likeness
