// Levenberg-Marquardt over pose increments and condition components. Derivatives are central differences of
// the rendering: exact enough at these step widths, and free of any assumption about the field.
#include "core/train/field_fit.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/base/check.h"
#include "core/base/dense_solves.h"
#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr double kTurnStep = 0.002, kShiftStep = 0.0003, kComponentStep = 0.05;  // rad, m, psi
constexpr double kTurnPrior = 0.5, kShiftPrior = 4;  // per rad and m; times kColourNoise, of one colour
constexpr double kComponentPrior = 0.01;             // per psi
constexpr double kColourNoise = 0.02;                // of a colour

// Changes that move the condition by one component only: the map's pseudo-inverse. (E + 9, C)
Eigen::MatrixXd component_directions(const ConditionMap& map, Eigen::Index components) {
  const Eigen::MatrixXd rows = map.rows.cast<double>();
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(rows.rows(), rows.rows());
  return (rows.transpose() * solve_symmetric_columns(rows * rows.transpose() + 1e-9 * one, one))
      .leftCols(components);
}

// As many samples as `final`, but in single precision, so that finite differences are smooth.
RenderOptions picture_options() {
  RenderOptions options = render_options(RenderQuality::final);
  options.reduce = 1, options.max_rays = 0;
  options.precision = FieldPrecision::exact;
  return options;
}

struct Problem {
  const Avatar& avatar;
  const AvatarRig& rig;
  const Camera& camera;
  const FieldTarget& target;
  const AvatarPose& tracked;
  std::vector<std::uint32_t> pixels;

  // lattice: of the same face, or null.
  Eigen::VectorXd residuals(const Eigen::VectorXd& x, const RenderState* same_face) const {
    const AvatarPose pose = changed_pose(tracked, avatar.condition, x);
    RenderState state = same_face ? *same_face : pose_avatar(rig, pose);
    state.pose.world_from_head = pose.world_from_head;
    const std::vector<float> rgba = render_pixels(avatar, camera, state, pixels, picture_options());
    const bool plate = target.plate && !target.plate->empty();
    Eigen::VectorXd r(Eigen::Index(3 * pixels.size()));
    for (std::size_t i = 0; i < pixels.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t at = 3 * pixels[i] + c;
        const float behind = plate ? float(target.plate->data[at]) / 255.f : 1.f;
        r[Eigen::Index(3 * i + c)] =
            rgba[4 * i + c] + (1 - rgba[4 * i + 3]) * behind - float(target.rgb->data[at]) / 255.f;
      }
    return r;
  }

  Eigen::MatrixXd jacobian(const Eigen::VectorXd& x, const Eigen::VectorXd& steps) const {
    const RenderState here = pose_avatar(rig, changed_pose(tracked, avatar.condition, x));
    Eigen::MatrixXd slopes(Eigen::Index(3 * pixels.size()), x.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      Eigen::VectorXd ahead = x, behind = x;
      ahead[k] += steps[k], behind[k] -= steps[k];
      const RenderState* face = k < kPoseChange ? &here : nullptr;
      slopes.col(k) = (residuals(ahead, face) - residuals(behind, face)) / (2 * steps[k]);
    }
    return slopes;
  }
};

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

AvatarPose changed_pose(const AvatarPose& tracked, const ConditionMap& map, const Eigen::VectorXd& change) {
  AvatarPose pose = tracked;
  if (change.size() == 0) return pose;
  LIKENESS_CHECK(change.size() >= kPoseChange && change.size() - kPoseChange <= map.rows.rows(),
                 "%d changes for a condition of %d components", int(change.size()), int(map.rows.rows()));
  const Vec3d turn = change.head<3>();
  const double angle = turn.norm();
  if (angle > 1e-12)
    pose.world_from_head.linear() = rotation_about(turn / angle, angle) * tracked.world_from_head.linear();
  pose.world_from_head.translation() += change.segment<3>(3);
  const Eigen::Index components = change.size() - kPoseChange;
  if (components == 0) return pose;
  const Eigen::VectorXf face =
      (component_directions(map, components) * change.tail(components)).cast<float>();
  Articulation& a = pose.articulation;
  const Eigen::Index e = a.expression.size();
  a.expression += face.head(e);
  a.jaw += face.segment<3>(e);
  a.left_eye += face.segment<3>(e + 3);
  a.right_eye += face.segment<3>(e + 6);
  return pose;
}

FieldFit fit_to_field(const Avatar& avatar, const AvatarRig& rig, const Camera& camera,
                      const FieldTarget& target, const AvatarPose& tracked, const Eigen::VectorXd& start,
                      const FieldFitOptions& options) {
  const Image8 &rgb = *target.rgb, &region = *target.region;
  LIKENESS_CHECK(rgb.channels == 3 && region.channels == 1 && region.width == rgb.width &&
                     region.height == rgb.height && rgb.width == camera.intrinsics.width,
                 "a region of %dx%d for a picture of %dx%d", region.width, region.height, rgb.width,
                 rgb.height);
  const Problem problem{avatar, rig,     camera,
                        target, tracked, draw_pixels(region, options.pixels, options.seed)};
  const auto n =
      Eigen::Index(kPoseChange) + std::min<Eigen::Index>(options.components, avatar.condition.rows.rows());
  Eigen::VectorXd steps(n), priors(n), x = Eigen::VectorXd::Zero(n);
  if (start.size() == n) x = start;
  for (Eigen::Index k = 0; k < n; ++k) {
    steps[k] = k < 3 ? kTurnStep : k < kPoseChange ? kShiftStep : kComponentStep;
    priors[k] = k < 3 ? kTurnPrior : k < kPoseChange ? kShiftPrior : kComponentPrior;
  }
  const Eigen::VectorXd weights =
      3.0 * double(problem.pixels.size()) * kColourNoise * kColourNoise * priors.cwiseAbs2();
  const auto cost_of = [&](const Eigen::VectorXd& r, const Eigen::VectorXd& at) {
    return r.squaredNorm() + weights.dot(at.cwiseAbs2());
  };
  FieldFit fit{x, 0, 0};
  if (problem.pixels.empty()) return fit;
  Eigen::VectorXd r = problem.residuals(x, nullptr);
  fit.mse_before = fit.mse_after = mean_square(r);
  double damping = 1e-3, cost = cost_of(r, x);
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    const Eigen::MatrixXd slopes = problem.jacobian(x, steps);
    Eigen::MatrixXd hessian = slopes.transpose() * slopes;
    hessian.diagonal() += weights;
    const Eigen::VectorXd gradient = slopes.transpose() * r + weights.cwiseProduct(x);
    bool better = false, settled = false;
    for (int attempt = 0; attempt < 4 && !better; ++attempt) {
      Eigen::MatrixXd damped = hessian;
      damped.diagonal() *= 1 + damping;
      const Eigen::VectorXd trial = x - solve_symmetric(damped, gradient);
      if (!trial.allFinite()) break;
      const Eigen::VectorXd trial_r = problem.residuals(trial, nullptr);
      const double trial_cost = cost_of(trial_r, trial);
      if (trial_cost < cost) {
        better = true;
        settled = cost - trial_cost < 1e-3 * cost;
        x = trial, r = trial_r, cost = trial_cost;
        damping = std::max(1e-6, damping * 0.2);
      } else {
        damping *= 10;
      }
    }
    if (!better || settled) break;
  }
  fit.change = x;
  fit.mse_after = mean_square(r);
  return fit;
}

}  // namespace likeness
