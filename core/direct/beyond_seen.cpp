// Compared with the ranges that hold, or with views and ranges of the capture: see beyond_seen.h.
#include "core/direct/beyond_seen.h"

#include <algorithm>
#include <numbers>

#include "core/holds/hold_words.h"

namespace likeness {
namespace {

constexpr float kBeyond = 0.15f;      // of an action, before it counts as further than seen
constexpr double kAllDoubt_deg = 30;  // beyond the nearest seen view
constexpr double kInDegrees = 180 / std::numbers::pi;

}  // namespace

BeyondSeen beyond_seen(const DirectedAvatar& directed, const SeenViews& views,
                       const std::map<std::string, ValueRange>& limits, const Performance& performance,
                       double time_s) {
  BeyondSeen beyond;
  const DirectedMoment moment = direct_moment(directed, performance, time_s);
  const ViewAngle view = view_angle(moment.camera.cam_from_world * moment.pose.world_from_head);
  beyond.view = view_beyond(*directed.avatar, views, view);
  if (const auto& holds = directed.avatar->holds) {
    beyond.checked = true;
    beyond.sides = sides_beyond(*holds, kInDegrees * view.yaw, kInDegrees * view.pitch);
  }
  for (const auto& [channel, keys] : performance.channels) {
    if (!channel.starts_with(kActionChannel)) continue;
    const auto seen = limits.find(channel);
    if (seen == limits.end()) continue;
    const float value = value_at(keys, time_s, 0);
    if (value > seen->second.high + kBeyond || value < seen->second.low - kBeyond)
      beyond.actions.push_back(channel.substr(kActionChannel.size()));
  }
  return beyond;
}

double view_beyond(const Avatar& avatar, const SeenViews& views, const ViewAngle& view) {
  if (const auto& holds = avatar.holds)
    return degrees_beyond(*holds, kInDegrees * view.yaw, kInDegrees * view.pitch) / kInDegrees;
  return views.views.empty() ? 0 : from_nearest_view(views, view.yaw, view.pitch);
}

double view_doubt(double beyond_rad) {
  const double deg = beyond_rad * kInDegrees;
  return std::clamp((deg - kViewMargin_deg) / (kAllDoubt_deg - kViewMargin_deg), 0.0, 1.0);
}

}  // namespace likeness
