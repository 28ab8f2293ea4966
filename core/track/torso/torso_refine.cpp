// Unknowns in blocks of one grid each: the mean, then the modes. A frame's Jacobian by block k is its
// Jacobian by displacements times its coefficient of mode k, so one (2P, 2P) matrix per frame serves all
// blocks. A step is judged by the pixels visible before it: a pixel that becomes hidden keeps its cost, so
// that hiding the torso gains nothing.
#include "core/track/torso/torso_refine.h"

#include <algorithm>
#include <utility>

#include "core/base/dense_solves.h"
#include "core/base/parallel.h"
#include "core/track/torso/torso_rows.h"

namespace likeness {
namespace {

// Between neighbouring nodes of mean and modes, per frame. A frame's free grid, which rests on its own
// picture alone, is a hundred times as stiff.
constexpr double kRefineStiffness = 1e6;  // grey levels^2 / m^2
constexpr int kOwn = kTorsoRigid + kTorsoModes, kBlocks = 1 + kTorsoModes;
constexpr int kMinPixels = 50;

struct TorsoSystem {
  bool used = false;
  double share = 0;                   // of kTorsoPixelsMeant
  Eigen::MatrixXd nodes, mixed, own;  // (2P, 2P), (2P, kOwn), (kOwn, kOwn)
  Eigen::VectorXd by_nodes, by_own;
  std::vector<float> costs;  // per pixel; negative: not seen
};

struct Problem {
  const std::vector<TorsoPixel>& pixels;
  const std::vector<TorsoView>& views;
  const Vec2d& pivot;
};

double shape_prior(double share) { return kTorsoShapeNoise * kTorsoShapeNoise * share; }

// The whole system of one frame. Its own unknowns are eliminated by the caller.
TorsoSystem frame_system(const Problem& problem, std::size_t view, const TorsoModes& modes,
                         const TorsoState& state) {
  TorsoSystem s;
  const int size = 2 * modes.grid.nodes();
  s.nodes.setZero(size, size), s.mixed.setZero(size, kOwn), s.own.setZero(kOwn, kOwn);
  s.by_nodes.setZero(size), s.by_own.setZero(kOwn);
  const Pose pose = motion_pose(state.motion, problem.pivot);
  double weights = 0;
  int count = 0;
  Eigen::Matrix<double, kOwn, 1> own;
  s.costs.assign(problem.pixels.size(), -1);
  for (std::size_t p = 0; p < problem.pixels.size(); ++p) {
    const TorsoPixel& pixel = problem.pixels[p];
    TorsoRow row;
    if (!torso_row(pixel, problem.views[view], pose, problem.pivot, modes.grid, state, &row)) continue;
    s.costs[p] = float(row.cost);
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
  s.used = count >= kMinPixels;
  s.share = weights / kTorsoPixelsMeant;
  for (int i = 0; i < kTorsoRigid; ++i) s.own(i, i) += kTorsoMotionPrior;
  if (problem.views[view].approaches) {
    s.own(3, 3) += kTorsoDepthPrior * s.share;
    s.by_own[3] += kTorsoDepthPrior * s.share * (state.motion.depth - problem.views[view].head_depth);
  }
  for (int m = 0; m < kTorsoModes; ++m) {
    s.own(kTorsoRigid + m, kTorsoRigid + m) += shape_prior(s.share);
    s.by_own[kTorsoRigid + m] += shape_prior(s.share) * state.shape[std::size_t(m)];
  }
  return s;
}

double frame_cost(const Problem& problem, std::size_t view, const TorsoModes& modes,
                  const TorsoSystem& before, const TorsoState& state) {
  const Pose pose = motion_pose(state.motion, problem.pivot);
  double sum = 0;
  for (std::size_t p = 0; p < problem.pixels.size(); ++p) {
    if (before.costs[p] < 0) continue;
    TorsoRow row;
    sum += torso_row(problem.pixels[p], problem.views[view], pose, problem.pivot, modes.grid, state, &row)
               ? row.cost
               : double(before.costs[p]);
  }
  for (const float c : state.shape) sum += 0.5 * shape_prior(before.share) * double(c) * double(c);
  if (problem.views[view].approaches) {
    const double off = state.motion.depth - problem.views[view].head_depth;
    sum += 0.5 * kTorsoDepthPrior * before.share * off * off;
  }
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

double used_share(const std::vector<TorsoSystem>& systems) {
  double share = 0;
  for (const TorsoSystem& s : systems) share += s.used ? s.share : 0;
  return share;
}

// Marquardt's damping, for a frame's own unknowns and for the modes'.
Eigen::MatrixXd damped(const Eigen::MatrixXd& hessian, double damping) {
  Eigen::MatrixXd result = hessian;
  result.diagonal() *= 1 + damping;
  return result;
}

// The step of mean and modes, (kBlocks * 2P), with every frame's own unknowns eliminated. Empty if there is
// none.
Eigen::VectorXd modes_step(const std::vector<TorsoSystem>& systems, const std::vector<TorsoState>& states,
                           const TorsoModes& modes, double damping) {
  const int size = 2 * modes.grid.nodes();
  std::vector<Eigen::MatrixXd> nodes(systems.size());
  std::vector<Eigen::VectorXd> by_nodes(systems.size());
  parallel_for(systems.size(), [&](std::size_t i) {
    const TorsoSystem& s = systems[i];
    if (!s.used) return;
    const Eigen::MatrixXd solved =
        solve_symmetric_columns(damped(s.own, damping), s.mixed.transpose());  // (kOwn, 2P)
    by_nodes[i] = s.by_nodes - solved.transpose() * s.by_own;
    nodes[i] = s.nodes - s.mixed * solved;
  });
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(kBlocks * size, kBlocks * size);  // lower triangle
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(kBlocks * size);
  // One row of blocks each: sums run in the frames' order, whatever the threads.
  parallel_for(kBlocks, [&](std::size_t row) {
    const int a = int(row);
    for (std::size_t i = 0; i < systems.size(); ++i) {
      if (!systems[i].used) continue;
      const double by_a = amount(states[i], a);
      gradient.segment(a * size, size) += by_a * by_nodes[i];
      for (int b = 0; b <= a; ++b)
        hessian.block(a * size, b * size, size, size) += by_a * amount(states[i], b) * nodes[i];
    }
  });
  for (int k = 0; k < kBlocks; ++k) {
    const Eigen::VectorXd at = Eigen::Map<const Eigen::VectorXf>(block(modes, k).data(), size).cast<double>();
    add_smoothness(modes.grid, kRefineStiffness * used_share(systems), &at, k * size, &hessian, &gradient,
                   nullptr);
  }
  const auto root = cholesky_factor(damped(hessian, damping));
  if (!root) return {};
  Eigen::VectorXd step = -solve_by_cholesky(*root, gradient);
  return step.allFinite() ? step : Eigen::VectorXd();
}

double total_cost(const Problem& problem, const TorsoModes& modes, const std::vector<TorsoSystem>& systems,
                  const std::vector<TorsoState>& states) {
  std::vector<double> costs(states.size(), 0);
  parallel_for(states.size(), [&](std::size_t i) {
    if (systems[i].used) costs[i] = frame_cost(problem, i, modes, systems[i], states[i]);
  });
  double sum = 0;
  for (const double c : costs) sum += c;
  const int size = 2 * modes.grid.nodes();
  for (int k = 0; k < kBlocks; ++k) {
    const Eigen::VectorXd at = Eigen::Map<const Eigen::VectorXf>(block(modes, k).data(), size).cast<double>();
    add_smoothness(modes.grid, kRefineStiffness * used_share(systems), &at, 0, nullptr, nullptr, &sum);
  }
  return sum;
}

// Back substitution: a frame's own unknowns after a step of the modes.
TorsoState stepped(const TorsoSystem& s, const TorsoState& state, const Eigen::VectorXd& step, double damping,
                   int size) {
  TorsoState moved = state;
  if (!s.used) return moved;
  Eigen::VectorXd displaced = Eigen::VectorXd::Zero(size);
  for (int k = 0; k < kBlocks; ++k) displaced += amount(state, k) * step.segment(k * size, size);
  const Eigen::VectorXd own =
      -solve_symmetric(damped(s.own, damping), s.by_own + s.mixed.transpose() * displaced);
  if (!own.allFinite()) return moved;
  moved.motion.angle += own[0];
  moved.motion.shift += own.segment<2>(1);
  moved.motion.depth += own[3];
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
  std::vector<TorsoState> now;
  for (const TorsoState* state : states) {
    now.push_back(*state);
    now.back().displacement = posed_displacement(*modes, state->shape);
  }
  double damping = 1e-4;
  for (bool better = true; better && report.steps < steps && !stop.stop_requested();) {
    std::vector<TorsoSystem> systems(now.size());
    parallel_for(now.size(), [&](std::size_t i) { systems[i] = frame_system(problem, i, *modes, now[i]); });
    if (used_share(systems) <= 0) break;
    const double cost = total_cost(problem, *modes, systems, now);
    if (report.steps == 0) report.cost_before = report.cost_after = cost;
    for (better = false; !better && damping < 1e4 && !stop.stop_requested(); damping *= better ? 0.1 : 10) {
      const Eigen::VectorXd step = modes_step(systems, now, *modes, damping);
      if (step.size() == 0) continue;
      TorsoModes tried = *modes;
      for (int k = 0; k < kBlocks; ++k)
        Eigen::Map<Eigen::VectorXf>(block(tried, k).data(), size) +=
            step.segment(k * size, size).cast<float>();
      std::vector<TorsoState> moved(now.size());
      parallel_for(now.size(), [&](std::size_t i) {
        moved[i] = stepped(systems[i], now[i], step, damping, size);
        moved[i].displacement = posed_displacement(tried, moved[i].shape);
      });
      const double then = total_cost(problem, tried, systems, moved);
      if (!(then < cost)) continue;
      better = true;
      *modes = std::move(tried);
      now = std::move(moved);
      report.cost_after = then;
      ++report.steps;
    }
    damping = std::max(1e-6, damping);
    if (report.steps > 0)
      for (std::size_t i = 0; i < now.size(); ++i)
        if (systems[i].used) *states[i] = now[i];
  }
  return report;
}

}  // namespace likeness
