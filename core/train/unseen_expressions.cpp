// Quantiles of amounts, and draws above them.
#include "core/train/unseen_expressions.h"

#include <algorithm>
#include <map>
#include <string>
#include <string_view>

#include "core/train/capture_summary.h"

namespace likeness {
namespace {

constexpr float kShownWhole = 0.8f;  // from which an action needs nothing
constexpr float kCommonShare = 0.6f;
constexpr std::uint32_t kMostActions = 3;

std::string without_side(const std::string& name) {
  return name.ends_with("_L") || name.ends_with("_R") ? name.substr(0, name.size() - 2) : name;
}

bool is_common(std::string_view name) { return name == "jawOpen" || name == "eyeBlink"; }

}  // namespace

UnseenExpressions unseen_expressions(const TrainingSet& set) {
  UnseenExpressions unseen;
  if (set.model.actions.empty()) return unseen;
  unseen.basis = action_basis(set.model);
  const Eigen::VectorXf rest = action_amounts(unseen.basis, typical_articulation(set));
  const std::vector<ActionRange> ranges = action_ranges(set);
  std::map<std::string, UnseenAction> by_name;
  for (std::size_t a = 0; a < ranges.size(); ++a) {
    if (ranges[a].name.starts_with("eyeLook")) continue;
    UnseenAction& action = by_name[without_side(ranges[a].name)];
    action.sides.push_back(a), action.rest.push_back(rest[Eigen::Index(a)]);
    action.seen = std::max({action.seen, 0.f, ranges[a].high - rest[Eigen::Index(a)]});
  }
  for (auto& [name, action] : by_name) {
    if (action.seen >= kShownWhole) continue;
    if (is_common(name)) unseen.common.push_back(unseen.actions.size());
    unseen.actions.push_back(std::move(action));
  }
  return unseen;
}

Articulation draw_unseen(const UnseenExpressions& unseen, const Articulation& moment, RandomStream& random) {
  Articulation drawn = moment;
  if (unseen.actions.empty()) return drawn;
  std::vector<std::size_t> chosen;
  for (const std::size_t a : unseen.common)
    if (random.uniform() < kCommonShare) chosen.push_back(a);
  const std::uint32_t count = 1 + random.below(kMostActions);
  while (chosen.size() < std::min<std::size_t>(count, unseen.actions.size())) {
    const std::size_t a = random.below(std::uint32_t(unseen.actions.size()));
    if (std::ranges::find(chosen, a) == chosen.end()) chosen.push_back(a);
  }
  const Eigen::VectorXf shown = action_amounts(unseen.basis, moment);
  for (const std::size_t a : chosen) {
    const UnseenAction& action = unseen.actions[a];
    const float amount = action.seen + (1 - action.seen) * random.uniform();
    for (std::size_t i = 0; i < action.sides.size(); ++i) {
      const std::size_t side = action.sides[i];
      const float already = std::max(0.f, shown[Eigen::Index(side)] - action.rest[i]);
      add_action(drawn, unseen.basis.actions[side], amount - already);
    }
  }
  return drawn;
}

}  // namespace likeness
