#include "core/track/fit_clip.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace likeness {
namespace {

// Seen training frames, at most `count` of them, evenly spread.
std::vector<int> spread_frames(const std::vector<FaceFrame>& frames, int count) {
  std::vector<int> all, chosen;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].seen && !frames[i].held_out) all.push_back(static_cast<int>(i));
  const int n = std::min<int>(count, static_cast<int>(all.size()));
  for (int k = 0; k < n; ++k) chosen.push_back(all[static_cast<std::size_t>(k) * all.size() / n]);
  return chosen;
}

struct JointSystem {
  std::vector<FrameSystem> frames;    // full systems, frame unknowns first, identity last
  std::vector<Eigen::MatrixXd> gain;  // (frame unknowns, I) of the back substitution
  std::vector<Eigen::VectorXd> offset;
};

// One damped Schur step: increments of the frames and of the identity.
bool schur_step(JointSystem& joint, int identities, double identity_weight, const Eigen::VectorXd& identity,
                double damping, Eigen::VectorXd* identity_step, std::vector<Eigen::VectorXd>* frame_steps) {
  const std::size_t n = joint.frames.size();
  std::vector<Eigen::MatrixXd> reduced(n);
  std::vector<Eigen::VectorXd> right(n);
  parallel_for(n, [&](std::size_t f) {
    const FrameSystem& s = joint.frames[f];
    const Eigen::Index face = s.hessian.rows() - identities;
    Eigen::MatrixXd own = s.hessian.topLeftCorner(face, face);
    own.diagonal() *= 1 + damping;
    const Eigen::MatrixXd cross = s.hessian.topRightCorner(face, identities);
    const Eigen::LDLT<Eigen::MatrixXd> factor(own);
    joint.gain[f] = factor.solve(cross);
    joint.offset[f] = factor.solve(s.gradient.head(face));
    reduced[f] = s.hessian.bottomRightCorner(identities, identities) - cross.transpose() * joint.gain[f];
    right[f] = s.gradient.tail(identities) - cross.transpose() * joint.offset[f];
  });
  Eigen::MatrixXd hessian =
      Eigen::MatrixXd::Identity(identities, identities) * (identity_weight * identity_weight);
  Eigen::VectorXd gradient = identity * (identity_weight * identity_weight);
  for (std::size_t f = 0; f < n; ++f)
    hessian += reduced[f], gradient += right[f];  // in order: repeatable sums
  hessian.diagonal() *= 1 + damping;
  *identity_step = -hessian.ldlt().solve(gradient);
  if (!identity_step->allFinite()) return false;
  frame_steps->resize(n);
  for (std::size_t f = 0; f < n; ++f) (*frame_steps)[f] = -joint.offset[f] - joint.gain[f] * *identity_step;
  return true;
}

// The neighbour at `offset` frames if it is one this frame may lean on, else null.
const FaceFrame* neighbour(const std::vector<FaceFrame>& frames, std::size_t i, int offset) {
  const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + offset;
  if (j < 0 || j >= static_cast<std::ptrdiff_t>(frames.size())) return nullptr;
  const FaceFrame& n = frames[j];
  if (!n.seen || n.frame != frames[i].frame + offset) return nullptr;
  if (frames[i].held_out ? offset > 0 : n.held_out) return nullptr;
  return &n;
}

FramePull temporal_pull(const std::vector<FaceFrame>& frames, std::size_t i, const ClipFitOptions& options) {
  FramePull pull;
  const FaceFrame& own = frames[i];
  const FaceFrame *a2 = neighbour(frames, i, -2), *a1 = neighbour(frames, i, -1),
                  *b1 = neighbour(frames, i, 1), *b2 = neighbour(frames, i, 2);
  // -- First differences of the face.
  double count = 0;
  pull.expression = Eigen::VectorXd::Zero(own.state.expression.size());
  for (const FaceFrame* n : {a1, b1})
    if (n) pull.expression += n->state.expression, pull.jaw += n->state.jaw, ++count;
  if (count > 0) {
    pull.expression /= count;
    pull.jaw /= count;
    pull.expression_weight = options.expression_change * std::sqrt(count);
    pull.jaw_weight =
        2 * options.expression_change * std::sqrt(count);  // a full opening is about half a radian
  }
  if (own.held_out || own.pose_given) return pull;
  // -- Second differences of the pose: each says where this frame should be, seen from its present place.
  const Pose here = own.state.cam_from_head;
  const auto turn = [&](const FaceFrame* n) {
    return vector_from_turn(n->state.cam_from_head.linear() * here.linear().transpose());
  };
  const auto shift = [&](const FaceFrame* n) { return n->state.cam_from_head.translation(); };
  Vec3d turn_sum = Vec3d::Zero(), shift_sum = Vec3d::Zero();
  double weight = 0;
  const auto add = [&](double w, const Vec3d& t, const Vec3d& s) {
    turn_sum += w * t, shift_sum += w * s, weight += w;
  };
  if (a1 && b1) add(4, 0.5 * (turn(a1) + turn(b1)), 0.5 * (shift(a1) + shift(b1)));
  if (a1 && a2) add(1, 2 * turn(a1) - turn(a2), 2 * shift(a1) - shift(a2));
  if (b1 && b2) add(1, 2 * turn(b1) - turn(b2), 2 * shift(b1) - shift(b2));
  if (weight > 0) {
    pull.turn_weight = options.turn_change * std::sqrt(weight);
    pull.shift_weight = options.shift_change * std::sqrt(weight);
    pull.cam_from_head.linear() = turn_from_vector(turn_sum / weight) * here.linear();
    pull.cam_from_head.translation() = shift_sum / weight;
  }
  return pull;
}

}  // namespace

void start_clip(const ReducedHead& head, const Eigen::VectorXd& identity, const ExpressionPrior& prior,
                std::vector<FaceFrame>& frames) {
  const ReducedPerson person = reduced_person(head, identity);
  parallel_for(frames.size(), [&](std::size_t i) {
    if (frames[i].seen) frames[i].state = start_frame(head, person, frames[i].observation, prior);
  });
}

Result<Eigen::VectorXd> fit_identity(const ReducedHead& head, const ExpressionPrior& usual_prior,
                                     const ClipFitOptions& options, const Eigen::VectorXd& start,
                                     std::vector<FaceFrame>& frames, const Progress& progress,
                                     std::stop_token stop) {
  const std::vector<int> chosen = spread_frames(frames, options.identity_frames);
  const std::size_t n = chosen.size();
  const int identities = head.identity_count(), unknowns = 7 + head.expression_count() + identities;
  const double weight = options.identity_weight * std::sqrt(static_cast<double>(n) / 100.0);
  const auto fit = [&](std::size_t f) {
    FrameFitOptions frame_options;
    frame_options.free_pose = !frames[chosen[f]].pose_given;
    return frame_options;
  };
  ExpressionPrior prior = usual_prior;
  prior.weight *= options.joint_expression;
  Eigen::VectorXd identity = start;
  JointSystem joint;
  joint.frames.resize(n), joint.gain.resize(n), joint.offset.resize(n);
  std::vector<JawLine> lines(n);

  const auto cost_of = [&](const Eigen::VectorXd& id, const std::vector<FaceState>& states) {
    const ReducedPerson person = reduced_person(head, id);
    std::vector<double> costs(n);
    parallel_for(n, [&](std::size_t f) {
      costs[f] =
          frame_cost(head, person, frames[chosen[f]].observation, lines[f], prior, {}, fit(f), states[f]);
    });
    double sum = 0.5 * weight * weight * id.squaredNorm();
    for (double c : costs) sum += c;
    return sum;
  };

  constexpr int kRounds = 4, kIterations = 8;
  std::vector<FaceState> states(n);
  for (std::size_t f = 0; f < n; ++f) states[f] = frames[chosen[f]].state;
  for (int round = 0; round < kRounds && n > 0; ++round) {
    const ReducedPerson now = reduced_person(head, identity);
    parallel_for(n, [&](std::size_t f) {
      lines[f] = pick_jaw_line(head, now, frames[chosen[f]].observation, states[f]);
    });
    double cost = cost_of(identity, states), damping = 1e-4;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      if (stop.stop_requested()) return cancelled_error();
      progress.report((round + static_cast<double>(iteration) / kIterations) / kRounds,
                      "fitting the identity");
      const ReducedPerson person = reduced_person(head, identity);
      parallel_for(n, [&](std::size_t f) {
        joint.frames[f].hessian.resize(unknowns, unknowns);
        frame_system(head, person, frames[chosen[f]].observation, lines[f], prior, {}, fit(f), states[f],
                     true, &joint.frames[f]);
      });
      bool better = false;
      double gain = 0;
      for (int attempt = 0; attempt < 5 && !better; ++attempt, damping *= 8) {
        Eigen::VectorXd identity_step;
        std::vector<Eigen::VectorXd> steps;
        if (!schur_step(joint, identities, weight, identity, damping, &identity_step, &steps)) break;
        std::vector<FaceState> trial(n);
        for (std::size_t f = 0; f < n; ++f) trial[f] = moved(states[f], steps[f]);
        const double trial_cost = cost_of(identity + identity_step, trial);
        if (trial_cost >= cost) continue;
        better = true;
        gain = cost - trial_cost;
        identity += identity_step;
        states = std::move(trial);
        cost = trial_cost;
        damping *= 0.02;
      }
      if (!better || gain < 1e-4 * cost) break;
    }
  }
  for (std::size_t f = 0; f < n; ++f) frames[chosen[f]].state = states[f];
  progress.report(1);
  return identity;
}

Result<void> fit_states(const ReducedHead& head, const Eigen::VectorXd& identity,
                        const ExpressionPrior& prior, const ClipFitOptions& options,
                        std::vector<FaceFrame>& frames, const Progress& progress, std::stop_token stop) {
  const ReducedPerson person = reduced_person(head, identity);
  const auto fit_one = [&](std::size_t i, bool with_neighbours) {
    FaceFrame& f = frames[i];
    if (!f.seen || stop.stop_requested()) return;
    FrameFitOptions fit;
    fit.free_pose = !f.pose_given;
    const FramePull pull = with_neighbours ? temporal_pull(frames, i, options) : FramePull{};
    f.state = fit_frame(head, person, f.observation, prior, pull, fit, f.state);
  };
  for (int sweep = 0; sweep <= options.sweeps; ++sweep) {
    progress.report(static_cast<double>(sweep) / (options.sweeps + 1), "fitting every frame");
    if (sweep == 0) {
      parallel_for(frames.size(), [&](std::size_t i) { fit_one(i, false); });
    } else {
      // A frame leans on two neighbours each side: every third frame can be fitted at once, in any order.
      for (std::size_t colour = 0; colour < 3; ++colour) {
        const std::size_t count = (frames.size() + 2 - colour) / 3;
        parallel_for(count, [&](std::size_t k) {
          if (!frames[3 * k + colour].held_out) fit_one(3 * k + colour, true);
        });
      }
    }
    if (stop.stop_requested()) return cancelled_error();
  }
  for (std::size_t i = 0; i < frames.size(); ++i)  // held-out frames lean on the one before: in order, once
    if (frames[i].held_out) fit_one(i, true);
  if (stop.stop_requested()) return cancelled_error();
  progress.report(1);
  return {};
}

}  // namespace likeness
