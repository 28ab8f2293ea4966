#include "core/track/photo/photometric_frame.h"

#include <algorithm>
#include <cmath>

#include "core/base/dense_solves.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/image/bilinear.h"
#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

constexpr double kKink = 1.5;           // spreads: beyond this an error counts linearly
constexpr double kMinSkinFacing = 0.2;  // cosine; more slanted skin is ignored
constexpr float kDepthSlack = 0.003f;
constexpr double kFeatureWeight = 1.3;  // lids and lips: few points decide
constexpr double kMinResidual = 5;      // encoded levels

double robust_cost(double r) { return r <= kKink ? 0.5 * r * r : kKink * (r - 0.5 * kKink); }

// Bilinear value and its exact derivative; false outside.
bool sample(const Image& picture, const Vec2d& px, double* value, Vec2d* gradient) {
  if (!inside_bilinear(picture, px.x(), px.y())) return false;
  *value = bilinear(picture, px.x(), px.y(), gradient ? gradient->data() : nullptr);
  return true;
}

// d pixel / d point in the camera frame.
Eigen::Matrix<double, 2, 3> projection_derivative(const Intrinsics& k, const Vec3d& p) {
  const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k.k1 + r2 * k.k2), rate = k.k1 + 2 * k.k2 * r2;
  Eigen::Matrix2d bend;
  bend(0, 0) = radial + 2 * x * x * rate + 2 * k.p1 * y + 6 * k.p2 * x;
  bend(0, 1) = bend(1, 0) = 2 * x * y * rate + 2 * k.p1 * x + 2 * k.p2 * y;
  bend(1, 1) = radial + 2 * y * y * rate + 6 * k.p1 * y + 2 * k.p2 * x;
  bend.row(0) *= k.fx;
  bend.row(1) *= k.fy;
  Eigen::Matrix<double, 2, 3> flat;
  flat << 1 / p.z(), 0, -x / p.z(), 0, 1 / p.z(), -y / p.z();
  return bend * flat;
}

// Posed, with a depth picture for visibility.
struct SeenSurface {
  PosedSurface posed;
  Raster raster;
  Intrinsics intrinsics;  // of the raster
};

SeenSurface see(const FaceSurface& surface, const FacePicture& picture, const FaceState& state) {
  SeenSurface seen;
  seen.posed = posed_surface(surface, state.expression, state.jaw);
  seen.intrinsics = picture.intrinsics[1];
  seen.raster = rasterise(seen.posed.points, surface.triangles, seen.intrinsics, state.cam_from_head);
  return seen;
}

// Cosine to the viewer, or 0 if the point is hidden.
double facing(const SeenSurface& seen, const FaceState& state, int point, Vec3d* in_cam) {
  *in_cam = state.cam_from_head * seen.posed.points[point].cast<double>();
  if (in_cam->z() < 0.05) return 0;
  const double cosine =
      -(state.cam_from_head.linear() * seen.posed.normals[point].cast<double>()).dot(in_cam->normalized());
  if (!(cosine > kMinSkinFacing)) return 0;
  const Vec2d px = project<double>(seen.intrinsics, *in_cam);
  const int x = static_cast<int>(px.x()), y = static_cast<int>(px.y());
  if (px.x() < 0 || px.y() < 0 || x >= seen.raster.width || y >= seen.raster.height) return 0;
  const float depth = seen.raster.depth[static_cast<std::size_t>(y) * seen.raster.width + x];
  return depth > 0 && in_cam->z() > depth + kDepthSlack ? 0 : cosine;
}

Image half(const Image& source) {
  Image out(std::max(1, source.width / 2), std::max(1, source.height / 2), 1);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const float *a = source.at(2 * x, 2 * y), *b = source.at(2 * x, std::min(2 * y + 1, source.height - 1));
      const int next = 2 * x + 1 < source.width ? 1 : 0;
      *out.at(x, y) = 0.25f * (a[0] + a[next] + b[0] + b[next]);
    }
  return out;
}

// Binomial 1 2 1 both ways: the gradient between neighbouring pixels then says something about both.
Image softened(const Image& source) {
  Image rows = source, out = source;
  for (int y = 0; y < source.height; ++y)
    for (int x = 1; x + 1 < source.width; ++x)
      *rows.at(x, y) = 0.25f * (*source.at(x - 1, y) + 2 * *source.at(x, y) + *source.at(x + 1, y));
  for (int y = 1; y + 1 < source.height; ++y)
    for (int x = 0; x < source.width; ++x)
      *out.at(x, y) = 0.25f * (*rows.at(x, y - 1) + 2 * *rows.at(x, y) + *rows.at(x, y + 1));
  return out;
}

}  // namespace

FacePicture face_picture(const Image8& grey, const Intrinsics& intrinsics) {
  FacePicture out;
  Image whole(grey.width, grey.height, 1);
  std::transform(grey.data.begin(), grey.data.end(), whole.data.begin(),
                 [](std::uint8_t v) { return static_cast<float>(v); });
  for (int l = 0; l < kPictureLevels; ++l) {
    out.picture[l] = softened(whole);
    Intrinsics k = intrinsics;
    const double s = 1.0 / (1 << l);
    k.width = whole.width, k.height = whole.height;
    k.fx *= s, k.fy *= s, k.cx *= s, k.cy *= s;
    out.intrinsics[l] = k;
    whole = half(whole);
  }
  return out;
}

FaceTarget face_target(const FaceSurface& surface, const Appearance& appearance, const FacePicture& picture,
                       int level, const std::vector<int>& chosen, const Mat3d& world_from_cam,
                       const FaceState& state) {
  const SeenSurface seen = see(surface, picture, state);
  const LitPoints& lit = appearance.level[level];
  const Mat3d turn = world_from_cam * state.cam_from_head.linear();
  FaceTarget target;
  target.level = level;
  std::vector<double> gains;
  for (int p : chosen) {
    if (lit.albedo[p] <= 0) continue;
    Vec3d in_cam;
    const double cosine = facing(seen, state, p, &in_cam);
    double level_there = 0;
    if (cosine == 0 || !sample(picture.picture[level], project<double>(picture.intrinsics[level], in_cam),
                               &level_there, nullptr))
      continue;
    const double value = encoded_of_linear(
        lit.albedo[p] * shade(appearance.light, turn * seen.posed.normals[p].cast<double>()));
    const double weight =
        std::sqrt(std::min(1.0, 2 * cosine)) * (surface.zone[p] == FaceZone::skin ? 1.0 : kFeatureWeight);
    target.point.push_back(p);
    target.value.push_back(value);
    target.scale.push_back(weight / std::max<double>(kMinResidual, lit.spread[p]));
    if (value > 10 && level_there > 5) gains.push_back(level_there / value);
  }
  // The camera's exposure drifts: one factor per frame, found in closed form and not stored.
  const double gain = gains.empty() ? 1 : std::clamp(median(std::move(gains)), 0.7, 1.4);
  for (double& v : target.value) v *= gain;
  return target;
}

std::vector<LightSample> light_samples(const FaceSurface& surface, const FacePicture& picture, int level,
                                       const Mat3d& world_from_cam, const FaceState& state) {
  const SeenSurface seen = see(surface, picture, state);
  const Mat3d turn = world_from_cam * state.cam_from_head.linear();
  std::vector<LightSample> samples;
  for (int p = 0; p < surface.points.points; ++p) {
    Vec3d in_cam;
    const double cosine = facing(seen, state, p, &in_cam);
    double value = 0;
    if (cosine == 0 ||
        !sample(picture.picture[level], project<double>(picture.intrinsics[level], in_cam), &value, nullptr))
      continue;
    samples.push_back({p, (turn * seen.posed.normals[p].cast<double>()).cast<float>(),
                       static_cast<float>(linear_of_encoded(value)), static_cast<float>(cosine * cosine)});
  }
  return samples;
}

void add_photometric(const FaceSurface& surface, const FacePicture& picture, const FaceTarget& target,
                     double weight, const FaceState& state, FrameSystem* system) {
  const int expressions = surface.points.expression_count(), unknowns = 7 + expressions;
  const bool derivatives = system->hessian.rows() == unknowns;
  const Image& image = picture.picture[target.level];
  const Intrinsics& k = picture.intrinsics[target.level];
  const Mat3d turn = state.cam_from_head.linear();
  const Eigen::Index count = static_cast<Eigen::Index>(target.point.size());
  RowMatrix rows = RowMatrix::Zero(derivatives ? count : 0, unknowns);
  Eigen::VectorXd residuals = Eigen::VectorXd::Zero(derivatives ? count : 0);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int p = target.point[i];
    PointDerivatives by;
    const Vec3d in_head = reduced_point(surface.points, surface.person, p, state.expression, state.jaw,
                                        derivatives ? &by : nullptr);
    const Vec3d turned = turn * in_head, in_cam = turned + state.cam_from_head.translation();
    double value = 0;
    Vec2d gradient;
    if (in_cam.z() < 0.05 ||
        !sample(image, project<double>(k, in_cam), &value, derivatives ? &gradient : nullptr)) {
      system->cost +=
          weight * weight * robust_cost(2 * kKink);  // leaving the picture must not lower the cost
      continue;
    }
    const double r = target.scale[i] * (value - target.value[i]), size = std::abs(r);
    system->cost += weight * weight * robust_cost(size);
    if (!derivatives) continue;
    const double robust = weight * (size <= kKink ? 1.0 : std::sqrt(kKink / size));
    residuals[i] = robust * r;
    const Eigen::RowVector3d by_cam =
        robust * target.scale[i] * (gradient.transpose() * projection_derivative(k, in_cam));
    const Eigen::RowVector3d by_head = by_cam * turn, by_shape = by_head * by.by_shape;
    auto row = rows.row(i);
    row.head<3>() = -by_cam * cross_matrix(turned);
    row.segment<3>(3) = by_cam;
    row[6] = by_head * by.by_jaw;
    row.tail(expressions).noalias() = by_shape * surface.points.expression.middleRows(3 * p, 3);
  }
  if (!derivatives) return;
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(unknowns, unknowns);
  square.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
  square.triangularView<Eigen::StrictlyUpper>() = square.transpose();
  system->hessian += square;
  system->gradient += rows.transpose() * residuals;
}

FaceState refine_state(const FrameEvidenceTerms& terms, int level, int iterations, const FaceState& guess) {
  const int unknowns = 7 + terms.head.expression_count();
  const std::vector<int>& chosen = level == 0 ? terms.surface.fine : terms.surface.coarse;
  const FrameFitOptions fit;
  FaceState state = guess;
  const JawLine line = pick_jaw_line(terms.head, terms.person, terms.observation, state);
  const FaceTarget target =
      face_target(terms.surface, terms.appearance, terms.picture, level, chosen, terms.world_from_cam, state);
  const auto evaluate = [&](const FaceState& at, bool derivatives, FrameSystem* system) {
    if (derivatives) system->hessian.resize(unknowns, unknowns);
    frame_system(terms.head, terms.person, terms.observation, line, terms.prior, terms.pull, fit, at, false,
                 system);
    add_photometric(terms.surface, terms.picture, target, terms.weight, at, system);
  };
  double damping = 1e-3;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    FrameSystem system;
    evaluate(state, true, &system);
    bool better = false, settled = false;
    for (int attempt = 0; attempt < 4 && !better; ++attempt) {
      Eigen::MatrixXd damped = system.hessian;
      damped.diagonal() *= 1 + damping;
      const Eigen::VectorXd step = -solve_symmetric(damped, system.gradient);
      if (!step.allFinite()) break;
      const FaceState trial = moved(state, step);
      FrameSystem there;
      if (trial.cam_from_head.translation().z() > 0.05) {
        evaluate(trial, false, &there);
        if (there.cost < system.cost) {
          better = true;
          settled = system.cost - there.cost < 1e-3 * system.cost;
          state = trial;
          damping = std::max(1e-6, damping * 0.2);
        }
      }
      if (!better) damping *= 10;
    }
    if (!better || settled) break;
  }
  state.cam_from_head.linear() =
      Eigen::Quaterniond(state.cam_from_head.linear()).normalized().toRotationMatrix();
  return state;
}

}  // namespace likeness
