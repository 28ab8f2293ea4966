// Seen ranges counted from rest: see seen_limits.h.
#include "core/direct/seen_limits.h"

#include <algorithm>
#include <numbers>

#include "core/head/action_amounts.h"

namespace likeness {
namespace {

// Degrees of [low, high], widened to hold rest.
ValueRange degrees(double low, double high) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  return {std::min(0.0f, float(low * kDegrees)), std::max(0.0f, float(high * kDegrees))};
}

}  // namespace

std::vector<SeenAction> seen_from_rest(const Avatar& avatar, const HeadModel& model) {
  const ActionBasis basis = action_basis(model);
  const Eigen::VectorXf rest = action_amounts(basis, avatar.neutral);
  std::vector<SeenAction> seen;
  for (const ActionRange& range : avatar.seen) {
    const int a = action_index(basis, range.name);
    if (a < 0) continue;
    seen.push_back({range.name, std::min(0.0f, range.low - rest[a]), std::max(0.0f, range.high - rest[a])});
  }
  for (const AttributeRegion& region : avatar.attributes)
    seen.push_back({region.name, std::min(0.0f, region.low), std::max(0.0f, region.high)});
  return seen;
}

std::map<std::string, ValueRange> seen_limits(const Avatar& avatar, const HeadModel& model,
                                              const SeenViews& views) {
  std::map<std::string, ValueRange> limits;
  for (const SeenAction& action : seen_from_rest(avatar, model))
    limits[action_channel(action.name)] = {action.low, action.high};
  // A head turned to its left shows what a camera further to its right would see.
  const ViewAngle typical = view_angle(avatar.cam_from_world * avatar.world_from_head);
  const ViewAngle &low = views.low, &high = views.high;
  limits["head yaw"] = degrees(typical.yaw - high.yaw, typical.yaw - low.yaw);
  limits["head pitch"] = degrees(low.pitch - typical.pitch, high.pitch - typical.pitch);
  limits["head roll"] = degrees(low.roll - typical.roll, high.roll - typical.roll);
  limits["camera yaw"] = degrees(low.yaw - typical.yaw, high.yaw - typical.yaw);
  limits["camera pitch"] = degrees(low.pitch - typical.pitch, high.pitch - typical.pitch);
  return limits;
}

}  // namespace likeness
