// What holds, in sentences for people.
#pragma once

#include <string>
#include <vector>

#include "core/holds/film_again.h"
#include "core/render/holding_range.h"

namespace likeness {

// Where an avatar stops to hold, and what to film; either is one sentence.
struct HoldRemark {
  std::string what, film_again;
};

// "It holds from 20 degrees on the person's right to 25 on the left, 10 below to 12 above."
std::string range_words(const HoldingRange& range);
// A remark for each side and each action that does not hold as far as was looked; mixes of actions are left
// out, as those that they are made of say what to film.
std::vector<HoldRemark> hold_remarks(const HoldingRange& range);

// Of a view that lies outside, degrees of the camera as seen from the head: the sides on which it does, the
// farthest outside first.
std::vector<HeadSide> sides_beyond(const HoldingRange& range, double yaw_deg, double pitch_deg);
// How far outside, degrees; 0 inside.
double degrees_beyond(const HoldingRange& range, double yaw_deg, double pitch_deg);
// What to film so that an action is held further: its own request, or a general one.
std::string film_again_action(const std::string& action);

}  // namespace likeness
