// Scores, verdicts, ranks.
#include "core/lab/beyond/check_agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace likeness {
namespace {

constexpr double kHeadLoss_db = 2, kPerAngle_deg = 15, kFaceLoss_db = 3;
constexpr double kMostDrift = 3, kLeastIou = 0.95, kIouUpTo_deg = 30, kMostSpecks = 0.0002, kMostForehead = 1;

// The worst of several figures in their limits.
struct Worst {
  double score = 0;
  std::string fault;
  void add(double share, const char* name) {
    if (std::isnan(share) || (!fault.empty() && share <= score)) return;
    score = std::max(share, 0.0), fault = name;
  }
};

Worst truth_of(const BeyondScore& inside, double inside_specks, const BeyondView& view) {
  Worst worst;
  const double away = std::hypot(view.yaw, view.pitch);
  if (inside.psnr_head_db && view.score.psnr_head_db)
    worst.add((*inside.psnr_head_db - *view.score.psnr_head_db) / (kHeadLoss_db * away / kPerAngle_deg),
              "psnr_head");
  worst.add(view.drift / kMostDrift, "drift");
  if (away <= kIouUpTo_deg) worst.add((1 - view.iou) / (1 - kLeastIou), "iou");
  worst.add((view.specks - inside_specks) / kMostSpecks, "specks");
  return worst;
}

Worst truth_of(const BeyondScore& inside, double inside_specks, const BeyondAction& action) {
  Worst worst;
  if (inside.psnr_face_db && action.score.psnr_face_db)
    worst.add((*inside.psnr_face_db - *action.score.psnr_face_db) / kFaceLoss_db, "psnr_face");
  if (action.forehead_change) worst.add(*action.forehead_change / kMostForehead, "forehead");
  worst.add((action.specks - inside_specks) / kMostSpecks, "specks");
  return worst;
}

std::string fault_name(const HoldScore& score) {
  return score.fault ? std::string(hold_rule(*score.fault).name) : std::string();
}

// Places in the ascending order, equal ones sharing theirs.
std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<double> out(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    double below = 0, same = 0;
    for (const double v : values) below += v < values[i], same += v == values[i];
    out[i] = below + 0.5 * (same - 1);
  }
  return out;
}

std::optional<double> rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> x = ranks(a), y = ranks(b);
  const double mean = 0.5 * (double(x.size()) - 1);
  double xy = 0, xx = 0, yy = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    xy += (x[i] - mean) * (y[i] - mean), xx += (x[i] - mean) * (x[i] - mean),
        yy += (y[i] - mean) * (y[i] - mean);
  if (xx == 0 || yy == 0) return std::nullopt;
  return xy / std::sqrt(xx * yy);
}

// The try nearest to the view asked for; the check goes outwards from the typical view, which need not be the
// front.
const HoldView* nearest_try(const HoldCheck& check, const BeyondView& view) {
  const HoldView* nearest = nullptr;
  double least = 0;
  for (const HoldView& tried : check.views) {
    const double yaw = view.yaw == 0 ? check.typical_yaw_deg : view.yaw,
                 pitch = view.pitch == 0 ? check.typical_pitch_deg : view.pitch,
                 away = std::hypot(tried.yaw_deg - yaw, tried.pitch_deg - pitch);
    if (!nearest || away < least) nearest = &tried, least = away;
  }
  return nearest;
}

}  // namespace

std::vector<CheckedCase> checked_cases(const BeyondStudy& study) {
  std::vector<CheckedCase> cases;
  const auto add = [&](std::string name, bool action, const Worst& truth, const HoldScore& check,
                       bool holds) {
    cases.push_back({std::move(name), action, truth.score, check.score, truth.fault, fault_name(check),
                     truth.score <= 1, holds});
  };
  const HoldCheck& check = study.holds;
  for (const BeyondView& view : study.views) {
    if (view.yaw == 0 && view.pitch == 0) continue;
    const HoldView* tried = nearest_try(check, view);
    if (!tried) continue;
    const bool turned = view.yaw != 0;
    add(fmt::format("{} {:+.0f}", turned ? "yaw" : "pitch", turned ? view.yaw : view.pitch), false,
        truth_of(study.inside, study.inside_specks, view), hold_score(tried->figures),
        holds_view(check.range, turned ? view.yaw : check.typical_yaw_deg,
                   turned ? check.typical_pitch_deg : view.pitch));
  }
  for (const BeyondAction& action : study.actions) {
    const auto tried = std::ranges::find_if(check.actions, [&](const TriedAction& t) {
      return t.asked.name == action.name && t.asked.amount == action.amount;
    });
    if (tried == check.actions.end()) continue;
    add(fmt::format("{} {:.1f}", action.name, action.amount), true,
        truth_of(study.inside, study.inside_specks, action), hold_score(tried->figures),
        holds_action(check.range, action.name, action.amount));
  }
  return cases;
}

CheckAgreement check_agreement(const std::vector<CheckedCase>& cases) {
  CheckAgreement agreement;
  std::array<std::vector<double>, 2> truth, check;
  for (const CheckedCase& c : cases) {
    ++agreement.cases;
    agreement.wrong += c.truth_holds != c.check_holds;
    agreement.held += c.truth_holds, agreement.held_found += c.truth_holds && c.check_holds;
    agreement.claimed += c.check_holds, agreement.claimed_wrong += c.check_holds && !c.truth_holds;
    truth[c.action].push_back(c.truth), check[c.action].push_back(c.check);
  }
  agreement.rank_views = rank_correlation(truth[0], check[0]);
  agreement.rank_actions = rank_correlation(truth[1], check[1]);
  return agreement;
}

}  // namespace likeness
