// How far a moment of a performance leaves what the capture showed: what warnings and the fading of the view
// are made of.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/direct/direct_avatar.h"
#include "core/direct/seen_limits.h"

namespace likeness {

struct BeyondSeen {
  double view = 0;                   // rad between the view of the head and the nearest one that was seen
  std::vector<std::string> actions;  // names of those that go clearly further than they were seen to
};
BeyondSeen beyond_seen(const DirectedAvatar& directed, const SeenViews& views,
                       const std::map<std::string, ValueRange>& limits, const Performance& performance,
                       double time_s);

// 0 where the view was seen, 1 where nothing there was: rises between a few degrees beyond and thirty.
double view_doubt(double beyond_rad);
inline constexpr double kViewMargin_deg = 4;  // so far beyond, nothing is doubted yet

}  // namespace likeness
