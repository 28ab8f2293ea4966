// Ranges counted from rest: see seen_limits.h.
#include "core/direct/seen_limits.h"

#include <algorithm>
#include <iterator>
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
  ViewAngle low = views.low, high = views.high;
  if (const auto& holds = avatar.holds) {
    constexpr double kRadians = std::numbers::pi / 180;
    low.yaw = kRadians * holds->yaw_low.deg, high.yaw = kRadians * holds->yaw_high.deg;
    low.pitch = kRadians * holds->pitch_low.deg, high.pitch = kRadians * holds->pitch_high.deg;
    for (const HeldAction& action : holds->actions)
      for (const char* side : {"", "_L", "_R"})
        if (const auto own = limits.find(action_channel(action.name + side)); own != limits.end())
          own->second.high = action.amount;
  }
  limits["head yaw"] = degrees(typical.yaw - high.yaw, typical.yaw - low.yaw);
  limits["head pitch"] = degrees(low.pitch - typical.pitch, high.pitch - typical.pitch);
  limits["head roll"] = degrees(low.roll - typical.roll, high.roll - typical.roll);
  limits["camera yaw"] = degrees(low.yaw - typical.yaw, high.yaw - typical.yaw);
  limits["camera pitch"] = degrees(low.pitch - typical.pitch, high.pitch - typical.pitch);
  return limits;
}

bool limits_hold(const Avatar& avatar, std::string_view channel) {
  if (!avatar.holds) return false;
  constexpr std::string_view kTurns[] = {"head yaw", "head pitch", "camera yaw", "camera pitch"};
  if (std::ranges::find(kTurns, channel) != std::end(kTurns)) return true;
  return channel.starts_with(kActionChannel) &&
         std::ranges::any_of(avatar.holds->actions, [&](const HeldAction& action) {
           const std::string own = action_channel(action.name);
           return channel == own || channel == own + "_L" || channel == own + "_R";
         });
}

}  // namespace likeness
