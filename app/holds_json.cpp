// See holds_json.h.
#include "app/holds_json.h"

#include <cmath>

#include <fmt/format.h>

#include <string>

#include "app/standard_streams.h"
#include "core/holds/hold_rules.h"
#include "core/lab/beyond/check_agreement.h"

namespace likeness::app {
namespace {

Table agreement_table(const std::vector<CheckedCase>& cases) {
  Table table{.name = "agreement", .title = "What the check says, and the truth; up to 1 it holds"};
  table.columns = {{"name", "asked for"}, {"truth", "truth"},       {"truth_fault", "worst"},
                   {"check", "check"},    {"check_fault", "worst"}, {"verdicts", "verdicts"}};
  for (const CheckedCase& c : cases)
    table.rows.push_back({c.name, c.truth, c.truth_fault, c.check, c.check_fault,
                          c.truth_holds == c.check_holds ? c.truth_holds ? "both: holds" : "both: fails"
                          : c.truth_holds                ? "check wrong: fails"
                                                         : "check wrong: holds"});
  const CheckAgreement a = check_agreement(cases);
  const auto rank = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.2f}", *value) : std::string("-");
  };
  table.notes = {
      fmt::format("wrong {} of {}; of {} that hold {} found; of {} said to hold {} do not; rank "
                  "correlation {} (views), {} (actions)",
                  a.wrong, a.cases, a.held, a.held_found, a.claimed, a.claimed_wrong, rank(a.rank_views),
                  rank(a.rank_actions))};
  return table;
}

}  // namespace

nlohmann::json holds_json(const HoldingRange& range) {
  nlohmann::json actions = nlohmann::json::object();
  for (const HeldAction& action : range.actions) actions[action.name] = action.amount;
  return {{"yaw", {range.yaw_low.deg, range.yaw_high.deg}},
          {"pitch", {range.pitch_low.deg, range.pitch_high.deg}},
          {"actions", actions}};
}

nlohmann::json beyond_holds_json(const std::optional<HoldingRange>& range, const BeyondHolds& beyond) {
  using nlohmann::json;
  if (!range) return nullptr;
  constexpr const char* kSides[] = {"left", "right", "above", "below"};
  json sides = json::array(), actions = json::object(), again = json::array();
  for (const HeadSide side : beyond.sides) sides.push_back(kSides[std::size_t(side)]);
  for (const auto& [name, amount] : beyond.actions) actions[name] = amount;
  for (const HoldRemark& remark : beyond_remarks(beyond, *range)) again.push_back(remark.film_again);
  return {{"frames", beyond.frames},
          {"view_deg", beyond.view_deg},
          {"sides", sides},
          {"actions", actions},
          {"film_again", again}};
}

void warn_beyond_holds(const std::optional<HoldingRange>& range, const BeyondHolds& beyond) {
  if (!range || beyond.empty()) return;
  tell("{} {} beyond what the avatar holds; expect faults there. To film in addition:\n", beyond.frames,
       beyond.frames == 1 ? "frame goes" : "frames go");
  for (const HoldRemark& remark : beyond_remarks(beyond, *range))
    tell("  {}\n    {}\n", remark.what, remark.film_again);
}

Table check_table(const HoldCheck& check) {
  Table table{.name = "check", .title = "The avatar's own check, without the truth"};
  table.columns = {{"name", "asked for"}};
  for (int f = 0; f < kHoldFaults; ++f) {
    const std::string name(hold_rule(HoldFault(f)).name);
    table.columns.push_back({name, name, 4});
  }
  const auto add = [&](std::string name, const HoldFigures& figures) {
    std::vector<TableCell>& row = table.rows.emplace_back();
    row.emplace_back(std::move(name));
    for (const double value : figures.value) row.emplace_back(value);
  };
  for (const HoldView& view : check.views)
    add(fmt::format("{:+.1f} {:+.1f}", view.yaw_deg, view.pitch_deg), view.figures);
  for (const TriedAction& tried : check.actions)
    add(fmt::format("{} {:.1f}", tried.asked.name, tried.asked.amount), tried.figures);
  table.notes = {fmt::format("{:.1f} s", check.seconds)};
  return table;
}

nlohmann::json check_json(const HoldCheck& check) {
  const auto known = [](double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
  };
  const nlohmann::json no_scores{
      {"psnr_head_db", nullptr}, {"psnr_face_db", nullptr}, {"psnr_person_db", nullptr}};
  nlohmann::json views = nlohmann::json::array(), actions = nlohmann::json::array();
  for (const HoldView& view : check.views) {
    nlohmann::json own = no_scores;
    own["yaw"] = view.yaw_deg, own["pitch"] = view.pitch_deg, own["iou"] = nullptr;
    own["drift"] = known(view.figures[HoldFault::drift]),
    own["specks"] = known(view.figures[HoldFault::specks]);
    own["depth_mm"] = known(view.figures[HoldFault::depth]);
    views.push_back(std::move(own));
  }
  for (const TriedAction& tried : check.actions)
    actions.push_back({{"name", tried.asked.name},
                       {"amount", tried.asked.amount},
                       {"psnr_face_db", nullptr},
                       {"forehead_change", known(tried.figures[HoldFault::forehead])},
                       {"specks", known(tried.figures[HoldFault::specks])}});
  return {{"inside", no_scores}, {"views", views}, {"actions", actions}, {"holds", holds_json(check.range)}};
}

std::vector<Table> holds_tables(const BeyondStudy& study) {
  return {check_table(study.holds), agreement_table(checked_cases(study))};
}

}  // namespace likeness::app
