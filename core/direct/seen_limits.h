// What an avatar's capture showed, in the terms in which it is directed: amounts on top of its rest, degrees
// away from its typical pose.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/direct/performance.h"
#include "core/head/action_amounts.h"
#include "core/project/seen_views.h"
#include "core/render/avatar.h"

namespace likeness {

// Per named action of the avatar, on top of rest, then per painted attribute; low <= 0 <= high.
std::vector<SeenAction> seen_from_rest(const Avatar& avatar, const HeadModel& model);

// Of a channel's values; low <= rest_value(channel) <= high.
struct ValueRange {
  float low = 0, high = 0;
};

// Ranges within which a channel shows nothing beyond the capture while the others rest. Left out: places,
// distance and gaze, which reveal nothing of the head that a turn does not.
std::map<std::string, ValueRange> seen_limits(const Avatar& avatar, const HeadModel& model,
                                              const SeenViews& views);

}  // namespace likeness
