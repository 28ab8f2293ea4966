// What of a film goes beyond what its avatar holds: the basis of warnings.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/head/head_model.h"
#include "core/holds/hold_words.h"
#include "core/render/avatar.h"
#include "core/render/film.h"
#include "core/render/holding_range.h"

namespace likeness {

struct BeyondHolds {
  int frames = 0;               // that go beyond, in a view or an action
  double view_deg = 0;          // outside the range, at most
  std::vector<HeadSide> sides;  // on which, the farthest outside first
  // Most of any frame, on top of rest, without their side; in the range's order.
  std::vector<std::pair<std::string, float>> actions;

  bool empty() const { return frames == 0; }
};

// A view a few degrees outside and an action a little beyond count as held: what an avatar shows there hardly
// differs from what holds.
BeyondHolds beyond_holds(const HoldingRange& range, const Avatar& avatar, const HeadModel& model,
                         const Film& film);

// Up to so far outside counts as held.
inline constexpr double kHoldMargin_deg = 2;
inline constexpr float kHoldMargin = 0.1f;  // of an action

// A sentence for each side and each action, and what to film.
std::vector<HoldRemark> beyond_remarks(const BeyondHolds& beyond, const HoldingRange& range);

}  // namespace likeness
