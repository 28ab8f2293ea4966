// What an avatar's capture showed, or how far the avatar was found to hold, in the terms in which it is
// directed: amounts on top of its rest, degrees away from its typical pose.
#pragma once

#include <map>
#include <string>
#include <string_view>
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

// Ranges within which a channel shows nothing that the avatar does not hold while the others rest: those of
// its own check where it has them (core/render/holding_range.h), of all else what the capture showed. Left
// out: places, distance and gaze, which reveal nothing of the head that a turn does not.
std::map<std::string, ValueRange> seen_limits(const Avatar& avatar, const HeadModel& model,
                                              const SeenViews& views);

// Whether a channel's limits are those that the avatar's own check found.
bool limits_hold(const Avatar& avatar, std::string_view channel);

}  // namespace likeness
