// When a picture of an avatar says that the avatar does not hold there.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "core/render/holding_range.h"

namespace likeness {

// What is measured of a picture, all but `mouth` and `lids` beyond what the same avatar has where it was
// filmed.
enum class HoldFault {
  missing,    // share of the posed head that one sees through
  outside,    // alpha outside the person's hull, as a share of the head's area
  loose,      // share of the person in pieces that hang loose
  shredded,   // share of the person's inside that one sees through
  drift,      // levels of 255: of the mean colour of forehead, nose, cheeks or chin
  painted,    // levels: mean change of the face's skin from what the front shows of the same places
  specks,     // share of the pixels of plain skin: neither lips nor lids
  depth,      // mm: median distance of where rays on the skin end from the posed head
  forehead,   // levels: mean change of the forehead, of actions that do not move it
  elsewhere,  // levels: mean change of what the action does not move
  lids,       // share of the lids where an eye was at rest that do not look like skin
  mouth,      // brightness of the open mouth's inside, as a share of the lips'
};
inline constexpr int kHoldFaults = 12;

// NaN: not measured there.
struct HoldFigures {
  std::array<double, kHoldFaults> value;
  HoldFigures() { value.fill(std::numeric_limits<double>::quiet_NaN()); }
  double& operator[](HoldFault fault) { return value[std::size_t(fault)]; }
  double operator[](HoldFault fault) const { return value[std::size_t(fault)]; }
};

struct HoldRule {
  std::string_view name;   // as kept in avatars and printed as JSON
  std::string_view words;  // completes "beyond that ..."
  double limit = 0;        // up to here it holds
};
const HoldRule& hold_rule(HoldFault fault);
// By its name; nullptr for one that is not known, as from a later version.
const HoldRule* find_hold_rule(std::string_view name);

// The figure that is farthest beyond its limit or nearest to it, in its limit: it holds up to 1.
struct HoldScore {
  double score = 0;
  std::optional<HoldFault> fault;  // that one; nullopt: nothing was measured
};
HoldScore hold_score(const HoldFigures& figures);

// One try on the way outwards.
struct HoldStep {
  double at = 0;  // degrees, or an amount
  HoldFigures figures;
};
// How far it holds, from `start` through the steps, in their order: up to the last step before the first that
// fails, and from there on as far as a straight line through both scores stays within 1.
HeldEnd hold_end(double start, std::span<const HoldStep> steps);

// Whether the avatar holds there. An action that was not tried: yes.
bool holds_view(const HoldingRange& range, double yaw_deg, double pitch_deg);
bool holds_action(const HoldingRange& range, std::string_view name, float amount);

}  // namespace likeness
