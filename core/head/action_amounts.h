// How much of each named action a face shows: from a model's own coefficients back to actions, which are what
// two head models have in common.
//
// Solved in the motion of the surface (m), not in coefficients, whose sizes are arbitrary: expression x and
// jaw rotation j move the vertices by D [x; j], D = [expression basis | derivative by the jaw at rest]; the
// amounts minimise |D (A a - [x; j])|^2 + a little ridge, A = the actions' coefficients. Linear. A thousandth
// of the coefficients' own distance breaks ties.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/head/head_model.h"

namespace likeness {

struct ActionBasis {
  Eigen::MatrixXf amounts_from_face;  // (A, E + 3)
  std::vector<NamedAction> actions;   // (A) the model's
};
ActionBasis action_basis(const HeadModel& model);  // costs about 0.1 s: keep it

// (A) 1 = full; from expression and jaw alone. The eyeballs are ignored: trackers measure gaze separately.
Eigen::VectorXf face_amounts(const ActionBasis& basis, const Articulation& articulation);

// (A) as above, but actions that turn an eyeball (eyeLook*) are judged by how far it is turned, >= 0.
Eigen::VectorXf action_amounts(const ActionBasis& basis, const Articulation& articulation);

// How much of an action a person's capture shows, 1 = full.
struct SeenAction {
  std::string name;
  float low = 0, high = 0;
};

// -1 if the basis has no such action.
int action_index(const ActionBasis& basis, std::string_view name);

// Squared size of a change of the face on the surface, m^2 summed over vertices: d^T G d for d = [x; j].
Eigen::MatrixXf face_metric(const HeadModel& model);  // (E + 3, E + 3)

}  // namespace likeness
