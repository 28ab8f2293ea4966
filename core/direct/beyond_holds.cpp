// Views and amounts of every frame.
#include "core/direct/beyond_holds.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <string_view>

#include "core/head/action_amounts.h"
#include "core/project/seen_views.h"

namespace likeness {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// Amounts on top of rest of the actions that were tried; of two sides, the larger.
class TriedAmounts {
 public:
  TriedAmounts(const HoldingRange& range, const Avatar& avatar, const HeadModel& model)
      : basis_(action_basis(model)), rest_(face_amounts(basis_, avatar.neutral)) {
    for (const HeldAction& action : range.actions)
      for (const char* side : {"", "_L", "_R"})
        if (const int a = action_index(basis_, action.name + side); a >= 0)
          places_.emplace_back(&action, Eigen::Index(a));
  }
  template <class Tell>
  void tell(const Articulation& face, const Tell& further) const {
    const Eigen::VectorXf amounts = face_amounts(basis_, face) - rest_;
    for (const auto& [action, a] : places_)
      if (amounts[a] > action->amount + kHoldMargin) further(*action, amounts[a]);
  }

 private:
  ActionBasis basis_;
  Eigen::VectorXf rest_;
  std::vector<std::pair<const HeldAction*, Eigen::Index>> places_;
};

}  // namespace

BeyondHolds beyond_holds(const HoldingRange& range, const Avatar& avatar, const HeadModel& model,
                         const Film& film) {
  const TriedAmounts tried(range, avatar, model);
  BeyondHolds beyond;
  std::map<std::string, float> most;
  std::map<HeadSide, double> most_of_side;
  for (std::size_t i = 0; i < film.frames; ++i) {
    const auto [camera, pose] = film.at(i);
    const ViewAngle view = view_angle(camera.cam_from_world * pose.world_from_head);
    const double yaw = view.yaw * kDegrees, pitch = view.pitch * kDegrees,
                 outside = degrees_beyond(range, yaw, pitch);
    bool further = outside > kHoldMargin_deg;
    if (further) {
      const auto note = [&](HeadSide side, double degrees) {
        if (degrees <= kHoldMargin_deg && degrees < outside / 2)
          return;  // what is hardly outside needs no word
        double& farthest = most_of_side[side];
        farthest = std::max(farthest, degrees);
      };
      for (const HeadSide side : sides_beyond(range, yaw, pitch))
        note(side, side == HeadSide::left || side == HeadSide::right
                       ? std::abs(yaw - std::clamp(yaw, range.yaw_low.deg, range.yaw_high.deg))
                       : std::abs(pitch - std::clamp(pitch, range.pitch_low.deg, range.pitch_high.deg)));
      beyond.view_deg = std::max(beyond.view_deg, outside);
    }
    tried.tell(pose.articulation, [&](const HeldAction& action, float amount) {
      further = true;
      float& own = most[action.name];
      own = std::max(own, amount);
    });
    beyond.frames += further;
  }
  for (const auto& [side, degrees] : most_of_side) beyond.sides.push_back(side);
  std::ranges::sort(beyond.sides,
                    [&](HeadSide a, HeadSide b) { return most_of_side.at(a) > most_of_side.at(b); });
  for (const HeldAction& action : range.actions)
    if (const auto found = most.find(action.name); found != most.end())
      beyond.actions.emplace_back(found->first, found->second);
  return beyond;
}

std::vector<HoldRemark> beyond_remarks(const BeyondHolds& beyond, const HoldingRange& range) {
  std::vector<HoldRemark> remarks;
  for (const HeadSide side : beyond.sides)
    remarks.push_back({fmt::format("Seen further from {} than the avatar holds.", side_words(side)),
                       std::string(film_again_side(side))});
  for (const auto& [name, amount] : beyond.actions) {
    const auto held = std::ranges::find(range.actions, name, &HeldAction::name);
    remarks.push_back({fmt::format("{} goes to {:.0f} %, the avatar holds it up to {:.0f} %.", name,
                                   100 * amount, held == range.actions.end() ? 0 : 100 * held->amount),
                       film_again_action(name)});
  }
  return remarks;
}

}  // namespace likeness
