// Expression presets: sets of named actions, scaled to what the capture showed.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/direct/performance.h"
#include "core/direct/set_values.h"
#include "core/head/action_amounts.h"
#include "core/head/head_model.h"

namespace likeness {

struct Preset {
  std::string name;                                    // neutral, smile, surprise, frown, A, E, I, O, U
  std::vector<std::pair<std::string, float>> actions;  // on top of rest, within what was seen
  float seen = 1;  // share of the usual expression that the capture can carry, 0..1; of neutral 1
};

// seen: from rest (seen_from_rest). Actions that the model does not know are left out.
std::vector<Preset> presets(const HeadModel& model, const std::vector<SeenAction>& seen);

// The preset's actions as sliders would set them (set_values.h); every other action goes to zero. Gaze stays.
void apply_preset(Performance& performance, const Preset& preset, const ValueEdit& edit);

}  // namespace likeness
