// The modes of a torso fitted to all learning frames' pictures at once. Components of free displacements, one
// frame each, say where deformations lie, but every frame's grid was kept smooth by itself: half of what
// moves is held back by that, and noise is among the rest. Here mean and modes are unknowns of one robust
// least-squares problem over all frames, each frame's motion and coefficients being eliminated from it (Schur
// complement): a bundle adjustment of a torso of low rank, in which smoothness is asked for once and not of
// every frame.
#pragma once

#include <stop_token>
#include <vector>

#include "core/track/torso_align.h"

namespace likeness {

struct TorsoRefinement {
  double cost_before = 0, cost_after = 0;  // with all priors, grey levels^2
  int steps = 0;                           // taken
};

// Levenberg-Marquardt. pixels: the template that all views share; states: one a view, followed with `modes`,
// or anywhere near; both are changed, and shapes keep no unit of their own: learn_torso_modes() of the
// states' displacements gives orthogonal modes of one standard deviation. The cost never rises. Views that
// show too little of the torso are left alone.
TorsoRefinement refine_torso_modes(const std::vector<TorsoPixel>& pixels, const std::vector<TorsoView>& views,
                                   const Vec2d& pivot, int steps, std::stop_token stop,
                                   const std::vector<TorsoState*>& states, TorsoModes* modes);

}  // namespace likeness
