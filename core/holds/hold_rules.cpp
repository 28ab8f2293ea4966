// Limits and what is made of them.
#include "core/holds/hold_rules.h"

#include <algorithm>
#include <cmath>

namespace likeness {
namespace {

constexpr double kSameDegree = 0.5;  // a view this little outside counts as inside
constexpr float kSameAmount = 0.001f;

// Chosen so that the verdicts agree with the truth on people of the demo, with and without proxies
// (`study beyond`, table `agreement`; figures: docs/METHOD.md); the same for everybody. Drift, forehead, lids
// and what lies elsewhere decide there. No demo avatar reached the limits of loose and depth: these are for
// clips whose jackets fall to pieces and whose cheeks come in layers.
constexpr std::array<HoldRule, kHoldFaults> kRules{{
    {"missing", "one sees through the head", 0.05},
    {"outside", "something stands off the head", 0.08},
    {"loose", "pieces hang loose", 0.01},
    {"shredded", "the body is torn", 0.05},
    {"drift", "the skin changes colour", 2},
    {"painted", "the face is another", 5},
    {"specks", "there are specks", 0.002},
    {"depth", "the face loses its shape", 2},
    {"forehead", "the forehead changes with it", 1},
    {"elsewhere", "places change that it does not move", 2},
    {"lids", "the lids do not close", 0.12},
    {"mouth", "the open mouth is not dark inside", 0.6},
}};

}  // namespace

const HoldRule& hold_rule(HoldFault fault) { return kRules[std::size_t(fault)]; }

const HoldRule* find_hold_rule(std::string_view name) {
  const auto found = std::ranges::find(kRules, name, &HoldRule::name);
  return found == kRules.end() ? nullptr : &*found;
}

HoldScore hold_score(const HoldFigures& figures) {
  HoldScore worst;
  for (int f = 0; f < kHoldFaults; ++f) {
    const auto fault = HoldFault(f);
    const double share = figures[fault] / hold_rule(fault).limit;
    if (std::isnan(share) || (worst.fault && share <= worst.score)) continue;
    worst = {share, fault};
  }
  worst.score = std::max(worst.score, 0.0);
  return worst;
}

HeldEnd hold_end(double start, std::span<const HoldStep> steps) {
  HeldEnd end{start, {}};
  double before = 0;
  for (const HoldStep& step : steps) {
    const HoldScore here = hold_score(step.figures);
    if (here.score > 1) {
      end.deg += (step.at - end.deg) * (1 - before) / (here.score - before);
      end.fault = hold_rule(*here.fault).name;
      return end;
    }
    end.deg = step.at, before = here.score;
  }
  return end;
}

bool holds_view(const HoldingRange& range, double yaw_deg, double pitch_deg) {
  return yaw_deg >= range.yaw_low.deg - kSameDegree && yaw_deg <= range.yaw_high.deg + kSameDegree &&
         pitch_deg >= range.pitch_low.deg - kSameDegree && pitch_deg <= range.pitch_high.deg + kSameDegree;
}

bool holds_action(const HoldingRange& range, std::string_view name, float amount) {
  const auto found = std::ranges::find(range.actions, name, &HeldAction::name);
  return found == range.actions.end() || amount <= found->amount + kSameAmount;
}

}  // namespace likeness
