// Named actions for a head model whose expressions have no names (FLAME): the built-in head's actions,
// carried over to the other mesh and expressed in its own coefficients.
//
// The two heads are registered by their 68 landmarks: a similarity, then a radial-basis warp w(x) =
// similarity(x) + sum_i c_i |x - x_i| (the thin-plate spline of space), which maps landmarks exactly. Every
// face vertex of the target takes the displacement of the closest point of the warped source, turned and
// scaled by the similarity; ridge least squares then finds the coefficients whose motion comes nearest.
#pragma once

#include <vector>

#include "core/head/head_model.h"

namespace likeness {

struct TransferOptions {
  float reach = 0.012f;      // m: a target vertex further from the warped source takes no part
  float max_misfit = 0.25f;  // of the landmarks after the similarity, as a share of the face's size
  float ridge = 1e-4f;       // on coefficients, relative to the basis' mean square motion
  float worst = 0.85f;       // actions of which more than this share cannot be represented are left out
};

// One action per action of `source` that `target` can make; jaw rotations stay rotations of the jaw joint,
// with expressions for what the joint alone does not do. Empty if the two faces do not correspond.
// NamedAction::residual says how much of the motion is missing. Costs about a second.
std::vector<NamedAction> transfer_actions(const HeadModel& source, const HeadModel& target,
                                          const TransferOptions& options = {});

}  // namespace likeness
