// Sentences.
#include "core/holds/hold_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
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

std::string beyond_it(const std::string& fault) {
  const HoldRule* rule = find_hold_rule(fault);
  return rule ? fmt::format("beyond that {}", rule->words) : std::string("beyond that it fails");
}

}  // namespace

std::string range_words(const HoldingRange& range) {
  return fmt::format(
      "It holds from {:.0f} degrees on the person's right to {:.0f} on the left, {:.0f} below to {:.0f} "
      "above.",
      -range.yaw_low.deg, range.yaw_high.deg, -range.pitch_low.deg, range.pitch_high.deg);
}

std::vector<HoldRemark> hold_remarks(const HoldingRange& range) {
  std::vector<HoldRemark> remarks;
  for (const SideEnd& own : side_ends(range))
    if (!own.end->fault.empty())
      remarks.push_back({fmt::format("From {} it holds up to {:.0f} degrees: {}.", side_words(own.side),
                                     own.reach_deg, beyond_it(own.end->fault)),
                         std::string(film_again_side(own.side))});
  for (const HeldAction& action : range.actions) {
    if (action.fault.empty() || action.name.find('+') != std::string::npos) continue;
    const FilmRequest* request = find_film_request(action.name);
    remarks.push_back(
        {fmt::format("{} holds up to {:.0f} %: {}.", request ? request->what : std::string_view(action.name),
                     100 * action.amount, beyond_it(action.fault)),
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
