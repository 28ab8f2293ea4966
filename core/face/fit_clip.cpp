#include "core/face/fit_clip.h"

#include <algorithm>
#include <cmath>

#include "core/base/dense_solves.h"
#include "core/base/parallel.h"
#include "core/base/parallel_batches.h"
#include "core/base/rigid.h"

namespace likeness {
namespace {

// Seen training frames, at most `count` of them, evenly spread, and all of the resting face.
std::vector<int> spread_frames(const std::vector<FaceFrame>& frames, int count) {
  std::vector<int> all, chosen;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].seen && !frames[i].held_out) {
      (frames[i].rest ? chosen : all).push_back(static_cast<int>(i));
    }
  const int n = std::min<int>(count, static_cast<int>(all.size()));
  for (int k = 0; k < n; ++k) chosen.push_back(all[static_cast<std::size_t>(k) * all.size() / n]);
  std::ranges::sort(chosen);
  return chosen;
}

// How much each chosen frame counts in the joint fit: those of the resting face together as much as all
// others, since a person who smiles through most of a clip is not shaped like their smile.
std::vector<double> joint_weights(const std::vector<FaceFrame>& frames, const std::vector<int>& chosen) {
  constexpr double kMost = 8;  // of one frame, whose landmarks may be off
  const auto rest = std::ranges::count_if(chosen, [&](int i) { return frames[i].rest; });
  const auto others = static_cast<std::ptrdiff_t>(chosen.size()) - rest;
  const double weight =
      rest > 0 ? std::clamp(static_cast<double>(others) / static_cast<double>(rest), 1.0, kMost) : 1.0;
  std::vector<double> weights;
  for (const int i : chosen) weights.push_back(frames[i].rest ? weight : 1.0);
  return weights;
}

constexpr int kRegistration = 6;  // unknowns: turn and shift of the head frame, in itself
constexpr double kRegistrationTurn = 10, kRegistrationShift = 33;  // prior per rad and m at 100 frames

// One frame's part of the joint fit: its own unknowns first, then what all frames share, the registration and
// the identity.
struct JointFrame {
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
  Eigen::Index own = 0;
  Eigen::MatrixXd gain;    // (own, shared) of the back substitution
  Eigen::VectorXd offset;  // (own)
};

// A given pose moves only with the head frame: its increment is replaced by the rotated registration.
JointFrame joint_frame(const FrameSystem& system, const FaceState& state, bool pose_given, int identities) {
  const Eigen::Index all = system.hessian.rows(), face = all - identities - kRegistration;
  const Eigen::Index own = pose_given ? face : kRegistration + face, shared = kRegistration + identities;
  JointFrame joint;
  joint.own = own;
  joint.hessian = Eigen::MatrixXd::Zero(own + shared, own + shared);
  joint.gradient = Eigen::VectorXd::Zero(own + shared);
  if (!pose_given) {
    const auto h = [&](Eigen::Index row, Eigen::Index column, Eigen::Index rows, Eigen::Index columns) {
      return system.hessian.block(row, column, rows, columns);
    };
    joint.hessian.topLeftCorner(own, own) = h(0, 0, own, own);
    joint.hessian.topRightCorner(own, identities) = h(0, own, own, identities);
    joint.hessian.bottomRightCorner(identities, identities) = h(own, own, identities, identities);
    joint.gradient.head(own) = system.gradient.head(own);
    joint.gradient.tail(identities) = system.gradient.tail(identities);
    return joint;
  }
  Eigen::Matrix<double, kRegistration, kRegistration> turned =
      Eigen::Matrix<double, kRegistration, kRegistration>::Zero();
  turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = state.cam_from_head.linear();
  const auto pose_rest = system.hessian.topRightCorner(kRegistration, face + identities);
  const auto rest = system.hessian.bottomRightCorner(face + identities, face + identities);
  joint.hessian.topLeftCorner(face, face) = rest.topLeftCorner(face, face);
  joint.hessian.block(0, own, face, kRegistration) = pose_rest.leftCols(face).transpose() * turned;
  joint.hessian.topRightCorner(face, identities) = rest.topRightCorner(face, identities);
  joint.hessian.block(own, own, kRegistration, kRegistration) =
      turned.transpose() * system.hessian.topLeftCorner(kRegistration, kRegistration) * turned;
  joint.hessian.block(own, own + kRegistration, kRegistration, identities) =
      turned.transpose() * pose_rest.rightCols(identities);
  joint.hessian.block(own + kRegistration, own, identities, kRegistration) =
      joint.hessian.block(own, own + kRegistration, kRegistration, identities).transpose();
  joint.hessian.bottomRightCorner(identities, identities) = rest.bottomRightCorner(identities, identities);
  joint.gradient.head(face) = system.gradient.segment(kRegistration, face);
  joint.gradient.segment(own, kRegistration) = turned.transpose() * system.gradient.head(kRegistration);
  joint.gradient.tail(identities) = system.gradient.tail(identities);
  return joint;
}

// Decouples the identity from everything else: its step is zero.
void hold_identity(int identities, JointFrame& joint) {
  joint.hessian.rightCols(identities).setZero();
  joint.hessian.bottomRows(identities).setZero();
  joint.hessian.diagonal().tail(identities).setOnes();
  joint.gradient.tail(identities).setZero();
}

// One damped Schur step: increments of the frames' own unknowns and of the shared ones. prior: (shared)
// weights, squared; at: the shared ones' current values.
bool schur_step(std::vector<JointFrame>& joint, const Eigen::VectorXd& prior, const Eigen::VectorXd& at,
                double damping, Eigen::VectorXd* shared_step, std::vector<Eigen::VectorXd>* frame_steps) {
  const std::size_t n = joint.size();
  const Eigen::Index shared = prior.size();
  std::vector<Eigen::MatrixXd> reduced(n);
  std::vector<Eigen::VectorXd> right(n);
  parallel_for(n, [&](std::size_t f) {
    JointFrame& s = joint[f];
    Eigen::MatrixXd own = s.hessian.topLeftCorner(s.own, s.own);
    own.diagonal() *= 1 + damping;
    const Eigen::MatrixXd cross = s.hessian.topRightCorner(s.own, shared);
    const SymmetricFactor factor(own);
    s.gain = factor.solve_columns(cross);
    s.offset = factor.solve(s.gradient.head(s.own));
    reduced[f] = s.hessian.bottomRightCorner(shared, shared) - cross.transpose() * s.gain;
    right[f] = s.gradient.tail(shared) - cross.transpose() * s.offset;
  });
  Eigen::MatrixXd hessian = prior.asDiagonal();
  Eigen::VectorXd gradient = prior.cwiseProduct(at);
  for (std::size_t f = 0; f < n; ++f)
    hessian += reduced[f], gradient += right[f];  // in order: repeatable sums
  hessian.diagonal() *= 1 + damping;
  *shared_step = -solve_symmetric(hessian, gradient);
  if (!shared_step->allFinite()) return false;
  frame_steps->resize(n);
  for (std::size_t f = 0; f < n; ++f) (*frame_steps)[f] = -joint[f].offset - joint[f].gain * *shared_step;
  return true;
}

// The state with its own unknowns and the head frame moved.
FaceState moved_jointly(const FaceState& state, const Eigen::VectorXd& own, bool pose_given,
                        const Eigen::VectorXd& shared) {
  if (!pose_given) return moved(state, own);
  const Mat3d turn = state.cam_from_head.linear();
  Eigen::VectorXd increment(kRegistration + own.size());
  increment << turn * shared.head<3>(), turn * shared.segment<3>(3), own;
  return moved(state, increment);
}

// The neighbour at `offset` frames if this frame may be smoothed with it, else null.
const FaceFrame* neighbour(const std::vector<FaceFrame>& frames, std::size_t i, int offset, int spacing) {
  const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + offset;
  if (j < 0 || j >= static_cast<std::ptrdiff_t>(frames.size())) return nullptr;
  const FaceFrame& n = frames[j];
  if (!n.seen || n.shot != frames[i].shot || n.frame != frames[i].frame + offset * spacing) return nullptr;
  if (frames[i].held_out ? offset > 0 : n.held_out) return nullptr;
  return &n;
}

FramePull temporal_pull(const std::vector<FaceFrame>& frames, std::size_t i, const ClipFitOptions& options) {
  FramePull pull;
  const FaceFrame& own = frames[i];
  const auto near = [&](int offset) { return neighbour(frames, i, offset, options.spacing); };
  const FaceFrame *a2 = near(-2), *a1 = near(-1), *b1 = near(1), *b2 = near(2);
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
  // -- Second differences of the pose: each gives where this frame should be, relative to its current pose.
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

Result<void> start_clip(const ReducedHead& head, const Eigen::VectorXd& identity,
                        const ExpressionPrior& prior, std::vector<FaceFrame>& frames,
                        const Progress& progress, std::stop_token stop) {
  const ReducedPerson person = reduced_person(head, identity);
  const auto start = [&](std::size_t i) {
    if (frames[i].seen) frames[i].state = start_frame(head, person, frames[i].observation, prior);
  };
  return parallel_batches(frames.size(), 64, start, progress, stop);
}

Result<IdentityFit> fit_identity(const ReducedHead& head, const ExpressionPrior& usual_prior,
                                 const ClipFitOptions& options, const Eigen::VectorXd& start,
                                 std::vector<FaceFrame>& frames, const Progress& progress,
                                 std::stop_token stop) {
  const std::vector<int> chosen = spread_frames(frames, options.identity_frames);
  const std::vector<double> counts = joint_weights(frames, chosen);
  const std::size_t n = chosen.size();
  const int identities = head.identity_count(), unknowns = 7 + head.expression_count() + identities;
  const auto given = [&](std::size_t f) { return frames[chosen[f]].pose_given; };
  ExpressionPrior prior = usual_prior;
  prior.weight *= options.joint_expression;
  // -- Shared unknowns: the registration, relative to its start, and the identity.
  double count = 0;
  for (const double c : counts) count += c / 100.0;
  Eigen::VectorXd shared = Eigen::VectorXd::Zero(kRegistration + identities);
  shared.tail(identities) = start;
  Eigen::VectorXd weights(shared.size());
  weights.head<3>().setConstant(count * kRegistrationTurn * kRegistrationTurn);
  weights.segment<3>(3).setConstant(count * kRegistrationShift * kRegistrationShift);
  weights.tail(identities).setConstant(count * options.identity_weight * options.identity_weight);
  if (options.hold_identity) weights.tail(identities).setZero();
  Pose registration = Pose::Identity();
  std::vector<JointFrame> joint(n);
  std::vector<JawLine> lines(n);

  const auto cost_of = [&](const Eigen::VectorXd& at, const std::vector<FaceState>& states) {
    const ReducedPerson person = reduced_person(head, at.tail(identities));
    std::vector<double> costs(n);
    parallel_for(n, [&](std::size_t f) {
      costs[f] = counts[f] *
                 frame_cost(head, person, frames[chosen[f]].observation, lines[f], prior, {}, {}, states[f]);
    });
    double sum = 0.5 * weights.dot(at.cwiseAbs2());
    for (double c : costs) sum += c;
    return sum;
  };

  constexpr int kRounds = 4, kIterations = 8;
  std::vector<FaceState> states(n);
  for (std::size_t f = 0; f < n; ++f) states[f] = frames[chosen[f]].state;
  for (int round = 0; round < kRounds && n > 0; ++round) {
    const ReducedPerson now = reduced_person(head, shared.tail(identities));
    parallel_for(n, [&](std::size_t f) {
      lines[f] = pick_jaw_line(head, now, frames[chosen[f]].observation, states[f]);
    });
    double cost = cost_of(shared, states), damping = 1e-4;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      if (stop.stop_requested()) return cancelled_error();
      progress.report((round + static_cast<double>(iteration) / kIterations) / kRounds,
                      "fitting the identity");
      const ReducedPerson person = reduced_person(head, shared.tail(identities));
      parallel_for(n, [&](std::size_t f) {
        FrameSystem system;
        system.hessian.resize(unknowns, unknowns);
        frame_system(head, person, frames[chosen[f]].observation, lines[f], prior, {}, {}, states[f], true,
                     &system);
        system.hessian *= counts[f], system.gradient *= counts[f];
        joint[f] = joint_frame(system, states[f], given(f), identities);
        if (options.hold_identity) hold_identity(identities, joint[f]);
      });
      bool better = false;
      double gain = 0;
      for (int attempt = 0; attempt < 5 && !better; ++attempt, damping *= 8) {
        Eigen::VectorXd step;
        std::vector<Eigen::VectorXd> steps;
        if (!schur_step(joint, weights, shared, damping, &step, &steps)) break;
        std::vector<FaceState> trial(n);
        for (std::size_t f = 0; f < n; ++f) trial[f] = moved_jointly(states[f], steps[f], given(f), step);
        const double trial_cost = cost_of(shared + step, trial);
        if (trial_cost >= cost) continue;
        better = true;
        gain = cost - trial_cost;
        shared += step;
        registration.translation() += registration.linear() * step.segment<3>(3);
        registration.linear() = registration.linear() * turn_from_vector(step.head<3>());
        states = std::move(trial);
        cost = trial_cost;
        damping *= 0.02;
      }
      if (!better || gain < 1e-4 * cost) break;
    }
  }
  // -- Every given pose moves, whether its frame was used or not.
  for (FaceFrame& frame : frames)
    if (frame.pose_given) frame.state.cam_from_head = frame.state.cam_from_head * registration;
  for (std::size_t f = 0; f < n; ++f) frames[chosen[f]].state = states[f];
  progress.report(1);
  return IdentityFit{shared.tail(identities), registration};
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
      // A frame depends on two neighbours on each side: every third frame can be fitted at once, in any
      // order.
      for (std::size_t colour = 0; colour < 3; ++colour) {
        const std::size_t count = (frames.size() + 2 - colour) / 3;
        parallel_for(count, [&](std::size_t k) {
          if (!frames[3 * k + colour].held_out) fit_one(3 * k + colour, true);
        });
      }
    }
    if (stop.stop_requested()) return cancelled_error();
  }
  for (std::size_t i = 0; i < frames.size(); ++i)  // held-out frames depend on the one before: in order, once
    if (frames[i].held_out) fit_one(i, true);
  if (stop.stop_requested()) return cancelled_error();
  progress.report(1);
  return {};
}

}  // namespace likeness
