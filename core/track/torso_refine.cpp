// Unknowns in blocks of one grid each: the mean, then the modes. A frame's Jacobian by block k is its
// Jacobian by displacements times its coefficient of mode k, so one (2P, 2P) matrix a frame serves all
// blocks.
#include "core/track/torso_refine.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/base/parallel.h"
#include "core/track/torso_rows.h"

namespace likeness {
namespace {

// Between neighbouring nodes of mean and modes, a frame; what one frame's free grid is asked for is a hundred
// times as stiff.
constexpr double kStiffness = 1e6;  // grey levels^2 / m^2
constexpr int kOwn = kTorsoRigid + kTorsoModes, kBlocks = 1 + kTorsoModes;
constexpr int kLeastPixels = 50;

struct FrameSystem {
  bool used = false;
  double share = 0;                   // of kTorsoPixelsMeant
  Eigen::MatrixXd nodes, mixed, own;  // (2P, 2P), (2P, kOwn), (kOwn, kOwn)
  Eigen::VectorXd by_nodes, by_own;
};

struct Problem {
  const std::vector<TorsoPixel>& pixels;
  const std::vector<TorsoView>& views;
  const Vec2d& pivot;
};

double shape_prior(double share) { return kTorsoShapeNoise * kTorsoShapeNoise * share; }

// The whole system of one frame. Its own unknowns are eliminated by the caller.
FrameSystem frame_system(const Problem& problem, std::size_t view, const TorsoModes& modes,
                         const TorsoState& state) {
  FrameSystem s;
  const int size = 2 * modes.grid.nodes();
  s.nodes.setZero(size, size), s.mixed.setZero(size, kOwn), s.own.setZero(kOwn, kOwn);
  s.by_nodes.setZero(size), s.by_own.setZero(kOwn);
  const Pose pose = motion_pose(state.motion, problem.pivot);
  double weights = 0;
  int count = 0;
  Eigen::Matrix<double, kOwn, 1> own;
  for (const TorsoPixel& pixel : problem.pixels) {
    TorsoRow row;
    if (!torso_row(pixel, problem.views[view], pose, problem.pivot, modes.grid, state, &row)) continue;
    weights += pixel.weight;
    ++count;
    own.head<kTorsoRigid>() = row.by;
    for (int m = 0; m < kTorsoModes; ++m) own[kTorsoRigid + m] = row.by_mode(modes.modes[std::size_t(m)]);
    for (int a = 0; a < 8; ++a) {
      const int i = row.node_index(a);
      const double weighted = row.weight * row.by_node(a);
      for (int b = 0; b < 8; ++b) s.nodes(i, row.node_index(b)) += weighted * row.by_node(b);
      s.mixed.row(i) += weighted * own.transpose();
      s.by_nodes[i] += weighted * row.residual;
    }
    s.own += row.weight * own * own.transpose();
    s.by_own += row.weight * row.residual * own;
  }
  s.used = count >= kLeastPixels;
  s.share = weights / kTorsoPixelsMeant;
  for (int i = 0; i < kTorsoRigid; ++i) s.own(i, i) += kTorsoMotionPrior;
  for (int m = 0; m < kTorsoModes; ++m) {
    s.own(kTorsoRigid + m, kTorsoRigid + m) += shape_prior(s.share);
    s.by_own[kTorsoRigid + m] += shape_prior(s.share) * state.shape[std::size_t(m)];
  }
  return s;
}

// Weights and shares are the frame's own, so a frame that comes to show less must not make the cost fall:
// those pixels count as they did at the start, at the Huber threshold.
struct FrameCost {
  double cost = 0;
  int seen = 0;
};
FrameCost frame_cost(const Problem& problem, std::size_t view, const TorsoModes& modes,
                     const TorsoState& state) {
  FrameCost sum;
  const Pose pose = motion_pose(state.motion, problem.pivot);
  double weights = 0;
  for (const TorsoPixel& pixel : problem.pixels) {
    if (pixel.weight <= 0) continue;
    TorsoRow row;
    if (torso_row(pixel, problem.views[view], pose, problem.pivot, modes.grid, state, &row)) {
      sum.cost += row.cost, weights += pixel.weight, ++sum.seen;
    } else {
      sum.cost += 0.5 * pixel.weight * kTorsoHuber * kTorsoHuber;
    }
  }
  for (const float c : state.shape)
    sum.cost += 0.5 * shape_prior(weights / kTorsoPixelsMeant) * double(c) * double(c);
  return sum;
}

const std::vector<float>& block(const TorsoModes& modes, int k) {
  return k == 0 ? modes.mean : modes.modes[std::size_t(k - 1)];
}
std::vector<float>& block(TorsoModes& modes, int k) {
  return k == 0 ? modes.mean : modes.modes[std::size_t(k - 1)];
}
double amount(const TorsoState& state, int k) {
  return k == 0 ? 1.0 : double(state.shape[std::size_t(k - 1)]);
}

struct Normals {
  Eigen::MatrixXd hessian;  // lower triangle
  Eigen::VectorXd gradient;
  double share = 0;
};

Normals reduced_normals(const std::vector<FrameSystem>& systems, const std::vector<TorsoState*>& states,
                        int size) {
  Normals n;
  n.hessian.setZero(kBlocks * size, kBlocks * size), n.gradient.setZero(kBlocks * size);
  for (const FrameSystem& s : systems) n.share += s.used ? s.share : 0;
  // A row of blocks each: every sum is made in the frames' order, whatever the threads.
  parallel_for(kBlocks, [&](std::size_t row) {
    const int a = int(row);
    for (std::size_t i = 0; i < systems.size(); ++i) {
      if (!systems[i].used) continue;
      const double by_a = amount(*states[i], a);
      n.gradient.segment(a * size, size) += by_a * systems[i].by_nodes;
      for (int b = 0; b <= a; ++b)
        n.hessian.block(a * size, b * size, size, size) += by_a * amount(*states[i], b) * systems[i].nodes;
    }
  });
  return n;
}

double smoothness_cost(const TorsoModes& modes, double share) {
  const int size = 2 * modes.grid.nodes();
  Eigen::MatrixXd unused = Eigen::MatrixXd::Zero(size, size);
  double cost = 0;
  for (int k = 0; k < kBlocks; ++k) {
    const Eigen::VectorXd at = Eigen::Map<const Eigen::VectorXf>(block(modes, k).data(), size).cast<double>();
    add_smoothness(modes.grid, kStiffness * share, &at, 0, unused, nullptr, &cost);
  }
  return cost;
}

double total_cost(const Problem& problem, const TorsoModes& modes, const std::vector<FrameSystem>& systems,
                  const std::vector<TorsoState>& states, double share) {
  std::vector<double> costs(states.size(), 0);
  parallel_for(states.size(), [&](std::size_t i) {
    if (!systems[i].used) return;
    const FrameCost c = frame_cost(problem, i, modes, states[i]);
    costs[i] = c.seen >= kLeastPixels ? c.cost : 1e30;
  });
  double sum = smoothness_cost(modes, share);
  for (const double c : costs) sum += c;
  return sum;
}

// What a step of the modes leaves for a frame's own unknowns.
TorsoState stepped(const FrameSystem& s, const TorsoState& state, const Eigen::VectorXd& step, int size) {
  TorsoState moved = state;
  if (!s.used) return moved;
  Eigen::VectorXd displaced = Eigen::VectorXd::Zero(size);
  for (int k = 0; k < kBlocks; ++k) displaced += amount(state, k) * step.segment(k * size, size);
  const Eigen::VectorXd own = -s.own.ldlt().solve(s.by_own + s.mixed.transpose() * displaced);
  if (!own.allFinite()) return moved;
  moved.motion.angle += own[0];
  moved.motion.shift += own.segment<2>(1);
  moved.motion.brightness += own[3];
  for (int m = 0; m < kTorsoModes; ++m) moved.shape[std::size_t(m)] += float(own[kTorsoRigid + m]);
  return moved;
}

}  // namespace

TorsoRefinement refine_torso_modes(const std::vector<TorsoPixel>& pixels, const std::vector<TorsoView>& views,
                                   const Vec2d& pivot, int steps, std::stop_token stop,
                                   const std::vector<TorsoState*>& states, TorsoModes* modes) {
  TorsoRefinement report;
  const Problem problem{pixels, views, pivot};
  const int size = 2 * modes->grid.nodes();
  for (TorsoState* state : states) state->displacement = posed_displacement(*modes, state->shape);
  double damping = 1e-4;
  for (int step_index = 0; step_index < steps && !stop.stop_requested(); ++step_index) {
    std::vector<FrameSystem> systems(states.size());
    parallel_for(states.size(), [&](std::size_t i) {
      FrameSystem& s = systems[i];
      s = frame_system(problem, i, *modes, *states[i]);
      if (!s.used) return;
      const Eigen::MatrixXd solved = s.own.ldlt().solve(s.mixed.transpose());  // (kOwn, 2P)
      s.by_nodes -= solved.transpose() * s.by_own;
      s.nodes -= s.mixed * solved;
    });
    Normals n = reduced_normals(systems, states, size);
    if (n.share <= 0) return report;
    for (int k = 0; k < kBlocks; ++k) {
      const Eigen::VectorXd at =
          Eigen::Map<const Eigen::VectorXf>(block(*modes, k).data(), size).cast<double>();
      add_smoothness(modes->grid, kStiffness * n.share, &at, k * size, n.hessian, &n.gradient);
    }
    std::vector<TorsoState> now;
    for (const TorsoState* state : states) now.push_back(*state);
    const double cost = total_cost(problem, *modes, systems, now, n.share);
    if (report.steps == 0) report.cost_before = report.cost_after = cost;

    bool better = false;
    for (; !better && damping < 1e4 && !stop.stop_requested(); damping *= better ? 1 : 10) {
      Eigen::MatrixXd damped = n.hessian;
      damped.diagonal() *= 1 + damping;
      const Eigen::LLT<Eigen::MatrixXd> root(damped);
      if (root.info() != Eigen::Success) continue;
      const Eigen::VectorXd step = -root.solve(n.gradient);
      if (!step.allFinite()) continue;
      TorsoModes tried = *modes;
      for (int k = 0; k < kBlocks; ++k)
        Eigen::Map<Eigen::VectorXf>(block(tried, k).data(), size) +=
            step.segment(k * size, size).cast<float>();
      std::vector<TorsoState> moved(states.size());
      parallel_for(states.size(), [&](std::size_t i) {
        moved[i] = stepped(systems[i], now[i], step, size);
        moved[i].displacement = posed_displacement(tried, moved[i].shape);
      });
      const double then = total_cost(problem, tried, systems, moved, n.share);
      if (!(then < cost)) continue;
      better = true;
      *modes = std::move(tried);
      for (std::size_t i = 0; i < states.size(); ++i) *states[i] = std::move(moved[i]);
      report.cost_after = then;
      ++report.steps;
    }
    if (!better) break;
    damping = std::max(1e-6, damping / 10);
  }
  return report;
}

}  // namespace likeness
