// How far a moment of a performance goes beyond what the capture showed: the basis of warnings and of fading
// the view.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/direct/direct_avatar.h"
#include "core/direct/seen_limits.h"

namespace likeness {

struct BeyondSeen {
  double view = 0;                   // rad between the view of the head and the nearest one that was seen
  std::vector<std::string> actions;  // names of those clearly beyond their seen range
};
BeyondSeen beyond_seen(const DirectedAvatar& directed, const SeenViews& views,
                       const std::map<std::string, ValueRange>& limits, const Performance& performance,
                       double time_s);

// 0 where the view was seen, 1 where nothing near it was: rises between a few degrees beyond and thirty.
double view_doubt(double beyond_rad);
inline constexpr double kViewMargin_deg = 4;  // up to this far beyond, the view still counts as seen

}  // namespace likeness
