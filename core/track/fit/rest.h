// Expressions counted from the person's resting face.
//
// An identity fitted to landmarks does not absorb everything constant in a face: the predictor places a
// closed mouth too narrow but not an open one, so that a face at rest reads as a pucker and a smile as no
// expression. While "no expression" means zero, the priors shift such a constant from shape to shape with
// whatever else the face does. So the resting face r is found in a first fit, and every prior and the lower
// end of every range count from it: weight |x - r|, x >= low + r.
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/face/fit_clip.h"
#include "core/head/head_model.h"

namespace likeness {

// usual: the model's prior, not specific to a person. rest: (E).
ExpressionPrior prior_from_rest(const ExpressionPrior& usual, const Eigen::VectorXd& rest);

// Fits every frame's state again, from the states given, counted from the rest that the frames marked as such
// show, or, where none is, all training frames (neutral.h); returns the prior for later fits. trust: see
// RestChoice. Costs two fits of all frames.
Result<ExpressionPrior> fit_from_rest(const HeadModel& model, const ReducedHead& head,
                                      const Eigen::VectorXd& identity, const ExpressionPrior& usual,
                                      const ClipFitOptions& options, std::vector<FaceFrame>& frames,
                                      const Progress& progress, std::stop_token stop, double trust = 1);

}  // namespace likeness
