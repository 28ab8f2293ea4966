// The modes of a torso fitted to all learning frames' pictures at once. Components of free displacements, one
// grid a frame, say where deformations lie; but what a single frame shows of a weakly textured jacket is
// little, so its grid is kept stiff, which holds back much of what moves. Here mean and modes are unknowns of
// one robust least-squares problem over all frames, each frame's motion and coefficients being eliminated
// from it (Schur complement): a bundle adjustment of a torso of low rank, which may be a hundred times
// softer.
#pragma once

#include <stop_token>
#include <vector>

#include "core/track/torso/torso_align.h"

namespace likeness {

struct TorsoRefinement {
  double cost_before = 0, cost_after = 0;  // with all priors, grey levels^2; each over what its step saw
  int steps = 0;                           // taken
};

// Levenberg-Marquardt. pixels: one pyramid level of the template, views of the same level; states: one a
// view, followed with `modes` or anywhere near; pivot: torso frame, m. Modes and states are changed, and
// shapes keep no unit of their own: learn_torso_modes() of the states' displacements gives orthogonal modes
// of one standard deviation. Only steps that lower the cost are taken. States of views that show too little
// of the torso stay as they are.
TorsoRefinement refine_torso_modes(const std::vector<TorsoPixel>& pixels, const std::vector<TorsoView>& views,
                                   const Vec2d& pivot, int steps, std::stop_token stop,
                                   const std::vector<TorsoState*>& states, TorsoModes* modes);

}  // namespace likeness
