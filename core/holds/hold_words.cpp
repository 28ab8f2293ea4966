// Sentences.
#include "core/holds/hold_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/holds/hold_rules.h"

namespace likeness {
namespace {

struct SideEnd {
  HeadSide side;
  double reach_deg;  // from the front, outwards
  const HeldEnd* end;
};

std::array<SideEnd, 4> side_ends(const HoldingRange& range) {
  return {{{HeadSide::left, range.yaw_high.deg, &range.yaw_high},
           {HeadSide::right, -range.yaw_low.deg, &range.yaw_low},
           {HeadSide::above, range.pitch_high.deg, &range.pitch_high},
           {HeadSide::below, -range.pitch_low.deg, &range.pitch_low}}};
}

std::string_view fault_words(const std::string& fault) {
  const HoldRule* rule = find_hold_rule(fault);
  return rule ? rule->words : std::string_view("it fails");
}

}  // namespace

std::string range_words(const HoldingRange& range) {
  const auto at = [](double deg, const char* unit, const char* below_zero, const char* above_zero) {
    return fmt::format("{:.0f}{} {}", std::abs(deg), unit, deg < 0 ? below_zero : above_zero);
  };
  return fmt::format("It holds from {} to {}, {} to {}.",
                     at(range.yaw_low.deg, " degrees", "on the person's right", "on the person's left"),
                     at(range.yaw_high.deg, "", "on the right", "on the left"),
                     at(range.pitch_low.deg, "", "below", "above"),
                     at(range.pitch_high.deg, "", "below", "above"));
}

std::vector<HoldRemark> hold_remarks(const HoldingRange& range) {
  std::vector<HoldRemark> remarks;
  for (const SideEnd& own : side_ends(range))
    if (!own.end->fault.empty())
      remarks.push_back({own.reach_deg >= 0.5
                             ? fmt::format("From {} it holds up to {:.0f} degrees: beyond that {}.",
                                           side_words(own.side), own.reach_deg, fault_words(own.end->fault))
                             : fmt::format("From {} it does not hold: {}.", side_words(own.side),
                                           fault_words(own.end->fault)),
                         std::string(film_again_side(own.side))});
  for (const HeldAction& action : range.actions) {
    if (action.fault.empty() || action.name.find('+') != std::string::npos) continue;
    const FilmRequest* request = find_film_request(action.name);
    remarks.push_back({fmt::format("{} holds up to {:.0f} %: beyond that {}.",
                                   request ? request->what : std::string_view(action.name),
                                   100 * action.amount, fault_words(action.fault)),
                       film_again_action(action.name)});
  }
  return remarks;
}

std::vector<HeadSide> sides_beyond(const HoldingRange& range, double yaw_deg, double pitch_deg) {
  std::vector<std::pair<double, HeadSide>> beyond;
  const std::array<double, 4> at{yaw_deg, -yaw_deg, pitch_deg, -pitch_deg};
  const auto ends = side_ends(range);
  for (std::size_t i = 0; i < ends.size(); ++i)
    if (at[i] > ends[i].reach_deg) beyond.emplace_back(at[i] - ends[i].reach_deg, ends[i].side);
  std::ranges::sort(beyond, std::greater{}, &std::pair<double, HeadSide>::first);
  std::vector<HeadSide> sides;
  for (const auto& [deg, side] : beyond) sides.push_back(side);
  return sides;
}

double degrees_beyond(const HoldingRange& range, double yaw_deg, double pitch_deg) {
  return std::hypot(yaw_deg - std::clamp(yaw_deg, range.yaw_low.deg, range.yaw_high.deg),
                    pitch_deg - std::clamp(pitch_deg, range.pitch_low.deg, range.pitch_high.deg));
}

std::string film_again_action(const std::string& action) {
  const FilmRequest* request = find_film_request(action);
  return request ? std::string(request->words)
                 : fmt::format("Do \"{}\" in the clip, slowly, as far as you can.", action);
}

}  // namespace likeness
