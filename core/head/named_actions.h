// The table of named facial actions of a model whose expressions have names.
#pragma once

#include <vector>

#include "core/head/head_model.h"

namespace likeness {

// One action per expression name: that coefficient at the top of its range, except that
// - jawOpen becomes the jaw rotation that makes the same motion, where the model has one (in ICT-FaceKit the
// shape
//   and a rotation of 25.33 degrees are equal): shape and joint must not both be free in a fit;
// - eyeLook* also turn the eyeball, as such shapes move only the lids.
// Empty for a model without expression names.
std::vector<NamedAction> make_named_actions(const HeadModel& model);

// The opening of the jaw joint about +x, rad, that best reproduces an expression shape, and how well.
struct JawMatch {
  float angle = 0;
  float relative_residual = 1;  // RMS left over / RMS of the shape; 0 = the same motion
};
JawMatch match_jaw_rotation(const HeadModel& model, int expression);

}  // namespace likeness
