// Levenberg-Marquardt over pose increments and condition components, derivatives by central differences of
// the rendering: exact enough at these step widths, and free of any assumption about the field.
#include "core/study/refit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "core/base/check.h"

namespace likeness {
namespace {

constexpr double kTurnStep = 0.002, kShiftStep = 0.0003, kComponentStep = 0.05;  // rad, m, psi
constexpr double kTurnPrior = 0.5, kShiftPrior = 4;  // per rad and m, against residuals of colour, per pixel
constexpr double kComponentPrior = 0.01;             // per psi
constexpr double kNoise = 0.02;                      // of a colour

struct Problem {
  const Avatar& avatar;
  const AvatarRig& rig;
  const Camera& camera;
  const Image& truth;
  const Image8& plate;
  const Pose &world_from_head, &world_from_torso;
  const Articulation& articulation;
  std::vector<std::uint32_t> pixels;
  Eigen::MatrixXf directions;  // (E + 9, C) articulation change for a unit of each component

  int unknowns() const { return 6 + int(directions.cols()); }

  Pose pose(const Eigen::VectorXd& x) const {
    // About the head's origin, so that turning does not shift it.
    Pose moved = world_from_head;
    const Vec3d turn = x.head<3>();
    const double angle = turn.norm();
    if (angle > 1e-12) moved.linear() = Eigen::AngleAxisd(angle, turn / angle) * moved.linear();
    moved.translation() += x.segment<3>(3);
    return moved;
  }

  Articulation face(const Eigen::VectorXd& x) const {
    if (directions.cols() == 0) return articulation;
    const Eigen::VectorXf change = directions * x.tail(directions.cols()).cast<float>();
    Articulation a = articulation;
    const Eigen::Index e = a.expression.size();
    a.expression += change.head(e);
    a.jaw += change.segment<3>(e);
    a.left_eye += change.segment<3>(e + 3);
    a.right_eye += change.segment<3>(e + 6);
    return a;
  }

  Eigen::VectorXd residuals(const Eigen::VectorXd& x) const {
    const RenderState state = pose_avatar(rig, pose(x), world_from_torso, face(x));
    const std::vector<float> rgba = render_pixels(avatar, camera, state, pixels);
    Eigen::VectorXd r(Eigen::Index(3 * pixels.size()));
    for (std::size_t i = 0; i < pixels.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t at = 3 * pixels[i] + c;
        const float behind = plate.empty() ? 1.f : float(plate.data[at]) / 255.f;
        r[Eigen::Index(3 * i + c)] = rgba[4 * i + c] + (1 - rgba[4 * i + 3]) * behind - truth.data[at];
      }
    return r;
  }
};

// What moves the condition by one component and nothing else: the map's pseudo-inverse.
Eigen::MatrixXf component_directions(const ConditionMap& map, int components) {
  const Eigen::Index k = std::min<Eigen::Index>(components, map.rows.rows());
  if (k == 0) return {};
  const Eigen::MatrixXd rows = map.rows.cast<double>();
  const Eigen::MatrixXd gram =
      rows * rows.transpose() + 1e-9 * Eigen::MatrixXd::Identity(rows.rows(), rows.rows());
  const Eigen::MatrixXd inverse =
      rows.transpose() * gram.ldlt().solve(Eigen::MatrixXd::Identity(rows.rows(), rows.rows()));
  return inverse.leftCols(k).cast<float>();
}

std::vector<std::uint32_t> draw_pixels(const Image8& region, int count, std::uint64_t seed) {
  std::vector<std::uint32_t> inside;
  for (std::size_t i = 0; i < region.data.size(); ++i)
    if (region.data[i] > 127) inside.push_back(std::uint32_t(i));
  std::mt19937_64 random(seed);
  for (std::size_t i = inside.size(); i > 1; --i) std::swap(inside[i - 1], inside[random() % i]);
  inside.resize(std::min(inside.size(), std::size_t(count)));
  std::sort(inside.begin(), inside.end());
  return inside;
}

double mean_square(const Eigen::VectorXd& r) {
  return r.squaredNorm() / double(std::max<Eigen::Index>(1, r.size()));
}

}  // namespace

Refit refit_frame(const Avatar& avatar, const AvatarRig& rig, const Camera& camera, const Image& truth,
                  const Image8& plate, const Image8& region, const Pose& world_from_head,
                  const Pose& world_from_torso, const Articulation& articulation,
                  const RefitOptions& options) {
  LIKENESS_CHECK(truth.channels == 3 && region.channels == 1 && region.width == truth.width &&
                     region.height == truth.height,
                 "a region of %dx%d for a picture of %dx%d", region.width, region.height, truth.width,
                 truth.height);
  const Problem problem{avatar,
                        rig,
                        camera,
                        truth,
                        plate,
                        world_from_head,
                        world_from_torso,
                        articulation,
                        draw_pixels(region, options.pixels, options.seed),
                        component_directions(avatar.condition, options.components)};
  const int n = problem.unknowns();
  Eigen::VectorXd steps(n), priors(n), x = Eigen::VectorXd::Zero(n);
  for (int k = 0; k < n; ++k) {
    steps[k] = k < 3 ? kTurnStep : k < 6 ? kShiftStep : kComponentStep;
    priors[k] = k < 3 ? kTurnPrior : k < 6 ? kShiftPrior : kComponentPrior;
  }
  const double trust = double(std::max<std::size_t>(1, 3 * problem.pixels.size()));
  const auto cost_of = [&](const Eigen::VectorXd& r, const Eigen::VectorXd& at) {
    return r.squaredNorm() + trust * kNoise * kNoise * priors.cwiseProduct(at).squaredNorm();
  };
  Eigen::VectorXd r = problem.residuals(x);
  Refit out;
  out.mse_before = mean_square(r);
  out.free_numbers = n;
  double damping = 1e-3, cost = cost_of(r, x);
  for (int iteration = 0; iteration < options.iterations && !problem.pixels.empty(); ++iteration) {
    Eigen::MatrixXd jacobian(r.size(), n);
    for (int k = 0; k < n; ++k) {
      Eigen::VectorXd ahead = x, behind = x;
      ahead[k] += steps[k], behind[k] -= steps[k];
      jacobian.col(k) = (problem.residuals(ahead) - problem.residuals(behind)) / (2 * steps[k]);
    }
    const Eigen::VectorXd weights = trust * kNoise * kNoise * priors.cwiseAbs2();
    Eigen::MatrixXd hessian = jacobian.transpose() * jacobian;
    hessian.diagonal() += weights;
    const Eigen::VectorXd gradient = jacobian.transpose() * r + weights.cwiseProduct(x);
    bool better = false;
    for (int attempt = 0; attempt < 4 && !better; ++attempt) {
      Eigen::MatrixXd damped = hessian;
      damped.diagonal() *= 1 + damping;
      const Eigen::VectorXd trial = x - damped.ldlt().solve(gradient);
      if (!trial.allFinite()) break;
      const Eigen::VectorXd trial_r = problem.residuals(trial);
      const double trial_cost = cost_of(trial_r, trial);
      if (trial_cost < cost) {
        better = cost - trial_cost > 1e-3 * cost;
        x = trial, r = trial_r, cost = trial_cost;
        damping = std::max(1e-6, damping * 0.2);
        if (!better) break;
      } else {
        damping *= 10;
      }
    }
    if (!better) break;
  }
  out.world_from_head = problem.pose(x);
  out.articulation = problem.face(x);
  out.mse_after = mean_square(r);
  return out;
}

}  // namespace likeness
