#include "core/track/fit/rest.h"

#include <set>

#include "core/track/fit/neutral.h"

namespace likeness {
namespace {

constexpr int kRounds = 2;  // the second rest is estimated from states that already count from the first

Eigen::VectorXd rest_of(const HeadModel& model, const std::vector<FaceFrame>& frames, double trust) {
  RestChoice rest;
  rest.trust = trust;
  std::vector<TrackedFrame> shown;
  std::set<int> held_out;
  for (const FaceFrame& frame : frames) {
    if (!frame.seen) continue;
    if (frame.held_out) held_out.insert(frame.frame);
    if (frame.rest) rest.frames.push_back(frame.frame);
    TrackedFrame& out = shown.emplace_back();
    out.frame = frame.frame;
    out.pose.world_from_head = frame.state.cam_from_head;
    out.pose.articulation = neutral_articulation(model);
    out.pose.articulation.expression = frame.state.expression.cast<float>();
    out.pose.articulation.jaw.x() = static_cast<float>(frame.state.jaw);
  }
  return calibrate_neutral(model, shown, held_out, rest).expression.cast<double>();
}

}  // namespace

ExpressionPrior prior_from_rest(const ExpressionPrior& usual, const Eigen::VectorXd& rest) {
  ExpressionPrior prior = usual;
  prior.rest = rest;
  prior.low = usual.low + rest;
  return prior;
}

Result<ExpressionPrior> fit_from_rest(const HeadModel& model, const ReducedHead& head,
                                      const Eigen::VectorXd& identity, const ExpressionPrior& usual,
                                      const ClipFitOptions& options, std::vector<FaceFrame>& frames,
                                      const Progress& progress, std::stop_token stop, double trust) {
  ExpressionPrior prior = usual;
  for (int round = 0; round < kRounds; ++round) {
    const Progress part =
        progress.stage(double(round) / kRounds, double(round + 1) / kRounds, "expressions from rest");
    prior = prior_from_rest(usual, rest_of(model, frames, trust));
    if (auto fitted = fit_states(head, identity, prior, options, frames, part, stop); !fitted)
      return fitted.error();
  }
  return prior;
}

}  // namespace likeness
