// What an avatar is asked for beyond what its clip shows: the views and the actions that are tried on it, and
// that a study puts beside the truth.
#pragma once

#include <string>
#include <vector>

#include "core/head/head_model.h"

namespace likeness {

// Where the camera stands, degrees from the front: yaw towards the subject's left, pitch above.
struct AskedView {
  double yaw = 0, pitch = 0;
};
const std::vector<AskedView>& asked_views();  // the front first

// What the face does, on top of its rest: one action, or several that no clip of ours performs together.
struct AskedAction {
  std::string name;                  // "jawOpen", or of a mix "jawOpen+browInnerUp"
  std::vector<std::string> actions;  // without their side; both are performed
  float amount = 0;                  // of each
};
const std::vector<AskedAction>& asked_actions();

// Those of the model's actions that are called so, or so with _L and _R behind.
std::vector<const NamedAction*> sides_of(const HeadModel& model, const std::string& action);
// Adds them.
void perform_asked(const HeadModel& model, const AskedAction& asked, Articulation& articulation);

}  // namespace likeness
