// How far a moment of a performance goes beyond what the avatar holds, or, where that is not known, beyond
// what its capture showed: the basis of warnings and of fading the view.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/direct/direct_avatar.h"
#include "core/direct/seen_limits.h"
#include "core/holds/film_again.h"

namespace likeness {

struct BeyondSeen {
  // rad between the view of the head and the range that holds, or the nearest one that was seen
  double view = 0;
  std::vector<std::string> actions;  // names of those clearly beyond their range
  bool checked = false;              // against what holds
  std::vector<HeadSide> sides;       // outside that range, the farthest outside first; empty if not checked
};
// Of a view alone.
double view_beyond(const Avatar& avatar, const SeenViews& views, const ViewAngle& view);
BeyondSeen beyond_seen(const DirectedAvatar& directed, const SeenViews& views,
                       const std::map<std::string, ValueRange>& limits, const Performance& performance,
                       double time_s);

// 0 where the view holds or was seen, 1 far from there: rises between a few degrees beyond and thirty.
double view_doubt(double beyond_rad);
inline constexpr double kViewMargin_deg = 4;  // up to this far beyond, the view still counts as held

}  // namespace likeness
