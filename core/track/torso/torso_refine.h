// The modes of a torso fitted to all learning frames' pictures at once. Components of free displacements, one
// grid per frame, locate the deformations; but a single frame shows little of a weakly textured jacket, so
// its grid is kept stiff, which suppresses much of the motion. Here mean and modes are unknowns of one robust
// least-squares problem over all frames, each frame's motion and coefficients being eliminated from it (Schur
// complement): a bundle adjustment of a low-rank torso, whose grids may be a hundred times softer.
#pragma once

#include <stop_token>
#include <vector>

#include "core/scene/torso_warp.h"
#include "core/track/torso/torso_picture.h"
#include "core/track/torso/torso_state.h"

namespace likeness {

struct TorsoRefinement {
  double cost_before = 0,
         cost_after = 0;  // with all priors, grey levels^2; each over the pixels its step saw
  int steps = 0;          // taken
};

// Levenberg-Marquardt. pixels: one pyramid level of the template, views of the same level; states: one per
// view, tracked with `modes` or near the solution; pivot: torso frame, m. Modes and states are changed, and
// the shapes' unit is not preserved: learn_torso_modes() of the states' displacements gives orthogonal modes
// of one standard deviation. Only steps that lower the cost are taken. States of views that show too little
// of the torso are unchanged.
TorsoRefinement refine_torso_modes(const std::vector<TorsoPixel>& pixels, const std::vector<TorsoView>& views,
                                   const Vec2d& pivot, int steps, std::stop_token stop,
                                   const std::vector<TorsoState*>& states, TorsoModes* modes);

}  // namespace likeness
