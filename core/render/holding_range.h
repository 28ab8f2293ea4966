// How far from what was filmed an avatar goes before its own pictures show that it fails, as core/holds
// found it after the training.
#pragma once

#include <string>
#include <vector>

namespace likeness {

// An end of a range of views.
struct HeldEnd {
  double deg = 0;
  std::string fault;  // what fails beyond it (core/holds/hold_rules.h); empty: nothing, as far as was looked
};

// Up to where an action holds, both sides of the face together.
struct HeldAction {
  std::string name;   // without _L and _R
  float amount = 0;   // on top of rest, 1 = full
  std::string fault;  // what fails beyond it; empty: nothing, all of it holds
};

// Where the camera stands as seen from the head, as ViewAngle has it (core/project/seen_views.h): yaw
// positive to the subject's left, pitch positive above. Each while the other is that of the typical view,
// from which all of them go outwards.
struct HoldingRange {
  HeldEnd yaw_low, yaw_high, pitch_low, pitch_high;
  std::vector<HeldAction> actions;  // those that were tried, in the order of core/holds/asked.h
};

}  // namespace likeness
