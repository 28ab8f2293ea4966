// Expressions that a clip never shows, made of the head model's named actions: what a face is asked to do
// beyond what its clip taught.
#pragma once

#include <cstddef>
#include <vector>

#include "core/head/action_amounts.h"
#include "core/train/random_stream.h"
#include "core/train/train.h"

namespace likeness {

// An action, both sides of the face together, that the clip shows at most in part.
struct UnseenAction {
  std::vector<std::size_t> sides;  // of the model's actions
  std::vector<float> rest;         // of each side, how much of it the face at rest shows
  float seen = 0;                  // the most that was seen of either side on top of that, 1 = full
};

struct UnseenExpressions {
  ActionBasis basis;
  std::vector<UnseenAction> actions;
  // Those of them that open the jaw or shut the lids, which a face does all the time; by their number in
  // `actions`.
  std::vector<std::size_t> common;
};

// Of all of the set's views. Gaze is left out: it moves the eyeballs, and lids but a little. Empty for a
// model without named actions.
UnseenExpressions unseen_expressions(const TrainingSet& set);

// One to three of the actions, farther than they were seen, on top of a moment's face. Without any action,
// the moment's face.
Articulation draw_unseen(const UnseenExpressions& unseen, const Articulation& moment, RandomStream& random);

}  // namespace likeness
