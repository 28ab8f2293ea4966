// See attribute_values.h.
#include "core/train/attribute_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/base/check.h"
#include "core/base/dense_solves.h"
#include "core/base/quantile.h"
#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

constexpr float kPaintedWithin = 1e-4f;                    // m: vertices that are painted
constexpr float kAroundFrom = 0.004f, kAroundTo = 0.016f;  // m from the paint
constexpr std::size_t kMaxPoints = 400;                    // of each kind
constexpr float kHiddenBehind = 0.004f, kSlanted = 0.25f;  // m; cosine below which skin is uninformative
constexpr float kNoLight = 0.02f;
constexpr float kFewest = 0.4f;  // of the points that must be seen
constexpr int kComponents = 10;
constexpr double kAsideRidge = 0.02;       // of the frames' number
constexpr double kAnnotationNoise = 0.03;  // error of the amounts that the user sets
constexpr double kDrift_per_s = 6;         // an amount may well change by this much in a second

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

std::vector<LookPoints::Point> thinned(std::vector<LookPoints::Point> points) {
  const std::size_t count = std::min(points.size(), kMaxPoints);
  std::vector<LookPoints::Point> kept;
  for (std::size_t i = 0; i < count; ++i) kept.push_back(points[i * points.size() / count]);
  return kept;
}

struct Sampler {
  const HeadModel& model;
  std::span<const Vec3f> posed;
  const Camera& camera;
  Pose cam_from_head;
  const Image8& rgb;
  Raster raster;

  // False if it is not seen well.
  bool look(const LookPoints::Point& point, Vec3f& colour) const {
    const Triangle& t = model.triangles[std::size_t(point.triangle)];
    const Vec3f &a = posed[std::size_t(t[0])], &b = posed[std::size_t(t[1])], &c = posed[std::size_t(t[2])];
    const Vec3f at = point.barycentric[0] * a + point.barycentric[1] * b + point.barycentric[2] * c;
    const Vec3d p = cam_from_head * at.cast<double>();
    const Vec3d normal = cam_from_head.linear() * (b - a).cross(c - a).normalized().cast<double>();
    if (p.z() < 1e-3 || -normal.dot(p.normalized()) < kSlanted) return false;
    const Vec2d pixel = project(camera.intrinsics, p);
    const int x = int(std::floor(pixel.x())), y = int(std::floor(pixel.y()));
    if (x < 1 || y < 1 || x + 1 >= rgb.width || y + 1 >= rgb.height) return false;
    const float depth = raster.depth[std::size_t(y) * std::size_t(rgb.width) + std::size_t(x)];
    if (depth > 0 && float(p.z()) > depth + kHiddenBehind) return false;
    // Bilinear between pixel centres.
    const double u = pixel.x() - 0.5, v = pixel.y() - 0.5;
    const int x0 = int(std::floor(u)), y0 = int(std::floor(v));
    const float fx = float(u - x0), fy = float(v - y0);
    for (int k = 0; k < 3; ++k) {
      const auto value = [&](int dx, int dy) {
        return float(
            rgb.at(std::clamp(x0 + dx, 0, rgb.width - 1), std::clamp(y0 + dy, 0, rgb.height - 1))[k]);
      };
      colour[k] = ((value(0, 0) * (1 - fx) + value(1, 0) * fx) * (1 - fy) +
                   (value(0, 1) * (1 - fx) + value(1, 1) * fx) * fy) /
                  255;
    }
    return true;
  }
};

// -- The frames as one matrix

struct Looks {
  Matrix colours;  // (N, 3 P), what is not seen at the training mean
  Matrix aside;    // (N, A + 1) standardised, and a constant
  std::vector<std::size_t> training;
};

Looks gather(std::span<const LookedFrame> frames) {
  const Eigen::Index n = Eigen::Index(frames.size()), d = frames[0].look.colours.size(),
                     a = frames[0].aside.size();
  Looks looks{Matrix::Zero(n, d), Matrix::Ones(n, a + 1), {}};
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].training && frames[i].look.share >= kFewest) looks.training.push_back(i);
  for (Eigen::Index k = 0; k < d; ++k) {
    double sum = 0, count = 0;
    for (const std::size_t i : looks.training)
      if (frames[i].look.seen[std::size_t(k / 3)]) sum += double(frames[i].look.colours[k]), ++count;
    const double mean = count > 0 ? sum / count : 0;
    for (std::size_t i = 0; i < frames.size(); ++i)
      if (frames[i].look.seen[std::size_t(k / 3)])
        looks.colours(Eigen::Index(i), k) = double(frames[i].look.colours[k]) - mean;
  }
  for (Eigen::Index k = 0; k < a; ++k) {
    double sum = 0, squares = 0;
    for (const std::size_t i : looks.training) sum += double(frames[i].aside[k]);
    const double mean = sum / double(std::max<std::size_t>(1, looks.training.size()));
    for (const std::size_t i : looks.training) squares += std::pow(double(frames[i].aside[k]) - mean, 2);
    const double deviation = std::sqrt(squares / double(std::max<std::size_t>(1, looks.training.size())));
    for (std::size_t i = 0; i < frames.size(); ++i)
      looks.aside(Eigen::Index(i), k) =
          deviation > 1e-9 ? std::clamp((double(frames[i].aside[k]) - mean) / deviation, -4.0, 4.0) : 0;
  }
  return looks;
}

Matrix rows_of(const Matrix& all, const std::vector<std::size_t>& chosen) {
  Matrix rows(Eigen::Index(chosen.size()), all.cols());
  for (std::size_t i = 0; i < chosen.size(); ++i)
    rows.row(Eigen::Index(i)) = all.row(Eigen::Index(chosen[i]));
  return rows;
}

// Removes what the aside explains.
Matrix without_aside(const Looks& looks) {
  const Matrix x = rows_of(looks.aside, looks.training), y = rows_of(looks.colours, looks.training);
  Matrix gram = x.transpose() * x;
  gram.diagonal().array() += kAsideRidge * double(looks.training.size());
  return looks.colours - looks.aside * solve_symmetric_columns(gram, x.transpose() * y);
}

// Coordinates (N, C) along the training looks' principal components, with total variance 1 over the training
// frames. power: of the deviation by which each component is divided; 0 keeps their proportion.
Matrix components_of(const Matrix& looks, const std::vector<std::size_t>& training, double power) {
  const Matrix learnt = rows_of(looks, training);
  const Vector mean = learnt.colwise().mean();
  const Matrix centred = learnt.rowwise() - mean.transpose();
  // From the smaller Gram matrix: there may be more points than frames, or fewer.
  Matrix axes;
  Vector variance;
  if (centred.rows() < centred.cols()) {
    const SymmetricEigen solved = eigen_of_symmetric(centred * centred.transpose());
    variance = solved.values.reverse();
    axes = centred.transpose() * solved.vectors.rowwise().reverse();
  } else {
    const SymmetricEigen solved = eigen_of_symmetric(centred.transpose() * centred);
    variance = solved.values.reverse();
    axes = solved.vectors.rowwise().reverse();
  }
  Eigen::Index count = 0;
  while (count < std::min<Eigen::Index>(kComponents, variance.size()) &&
         variance[count] > 1e-4 * std::max(variance[0], 1e-12))
    ++count;
  Matrix all(looks.rows(), count);
  for (Eigen::Index c = 0; c < count; ++c) {
    const Vector axis = axes.col(c).normalized();
    const double deviation = std::sqrt(variance[c] / double(std::max<Eigen::Index>(1, centred.rows())));
    all.col(c) = (looks.rowwise() - mean.transpose()) * axis / std::pow(deviation, power);
  }
  const double total =
      rows_of(all, training).squaredNorm() / double(std::max<std::size_t>(1, training.size()));
  return total > 0 ? Matrix(all / std::sqrt(total)) : all;
}

// -- The Gaussian process

struct CovarianceKernel {
  double length = 1;  // of the squared exponential; 0: linear, with a constant
  double noise = 0.1;
  double at(const Vector& a, const Vector& b) const {
    if (length == 0) return 0.5 + 2 * a.dot(b);
    return std::exp(-0.5 * (a - b).squaredNorm() / (length * length));
  }
};

struct Process {
  CovarianceKernel kernel;
  Matrix known;  // (n, C)
  SymmetricFactor factor;
  Vector weights;

  double log_density = 0, error = 0;  // leave-one-out: sum of ln p, rms

  Process(const CovarianceKernel& k, Matrix rows, const Vector& values) : kernel(k), known(std::move(rows)) {
    const Eigen::Index n = known.rows();
    Matrix gram(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) gram(i, j) = kernel.at(known.row(i), known.row(j));
    gram.diagonal().array() += kernel.noise * kernel.noise;
    factor = SymmetricFactor(gram);
    weights = factor.solve(values);
    const Matrix inverse = factor.solve_columns(Matrix::Identity(n, n));
    for (Eigen::Index i = 0; i < n; ++i) {
      const double variance = 1 / inverse(i, i), off = weights[i] * variance;
      log_density -= 0.5 * (std::log(variance) + off * off / variance);
      error += off * off / double(n);
    }
    error = std::sqrt(error);
  }

  // Mean, and the remaining share of the prior's deviation.
  FrameAmount predict(const Vector& at) const {
    Vector k(known.rows());
    for (Eigen::Index i = 0; i < k.size(); ++i) k[i] = kernel.at(known.row(i), at);
    const double prior = kernel.at(at, at), left = std::max(0.0, prior - k.dot(factor.solve(k)));
    return {float(k.dot(weights)), float(std::sqrt(left / prior))};
  }
};

// The annotated frames that show enough to be learnt from.
std::vector<std::size_t> teaching(std::span<const LookedFrame> frames) {
  std::vector<std::size_t> taught;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].annotated && frames[i].training && frames[i].look.share >= kFewest) taught.push_back(i);
  return taught;
}

// How unlike all annotated looks each frame's is, 0..1, whichever kernel was chosen: 0.6 if the nearest is
// 1.35 times as far as they are from each other.
std::vector<float> novelty_of(const Matrix& all, const std::vector<std::size_t>& annotated) {
  double apart = 0, pairs = 0;
  for (std::size_t i = 0; i < annotated.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      apart += (all.row(Eigen::Index(annotated[i])) - all.row(Eigen::Index(annotated[j]))).norm(), ++pairs;
  apart /= std::max(1.0, pairs);
  std::vector<float> novelty;
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const std::size_t a : annotated)
      nearest = std::min(nearest, (all.row(i) - all.row(Eigen::Index(a))).norm());
    novelty.push_back(apart > 0 ? float(1 - std::exp(-0.5 * std::pow(nearest / apart, 2))) : 0.f);
  }
  return novelty;
}

// From the least to the most that was annotated. A look unlike all annotated ones extrapolates far beyond,
// where an amount means nothing.
std::pair<double, double> annotated_range(std::span<const LookedFrame> frames) {
  double low = 1, high = -1;
  for (const LookedFrame& frame : frames)
    if (frame.annotated) low = std::min(low, frame.value), high = std::max(high, frame.value);
  return {low, std::max(low, high)};
}

// Kalman filter and Rauch-Tung-Striebel smoother of a random walk, over each run by itself.
void smooth_runs(std::span<const LookedFrame> frames, double noise, std::vector<FrameAmount>& amounts) {
  const auto [low, high] = annotated_range(frames);
  std::map<int, std::vector<std::size_t>> runs;
  for (std::size_t i = 0; i < frames.size(); ++i) runs[frames[i].run].push_back(i);
  for (const auto& [run, members] : runs) {
    const std::size_t n = members.size();
    std::vector<double> mean(n), variance(n), ahead(n);
    for (std::size_t i = 0; i < n; ++i) {
      const LookedFrame& frame = frames[members[i]];
      const double gap = i == 0 ? 0 : std::abs(frame.time_s - frames[members[i - 1]].time_s);
      const double before = i == 0 ? 0 : mean[i - 1];
      // Never wider than not knowing at all.
      ahead[i] = i == 0 ? 1 : std::min(1.0, variance[i - 1] + kDrift_per_s * kDrift_per_s * gap * gap);
      const double uncertainty = double(amounts[members[i]].uncertainty);
      const double observed =
          frame.annotated
              ? kAnnotationNoise * kAnnotationNoise
              : noise * noise + uncertainty * uncertainty / std::max(1e-3, 1 - uncertainty * uncertainty);
      const double gain = ahead[i] / (ahead[i] + observed);
      mean[i] = before + gain * (double(amounts[members[i]].value) - before);
      variance[i] = (1 - gain) * ahead[i];
    }
    for (std::size_t i = n; i-- > 0;) {
      if (i + 1 < n) {
        const double gain = std::min(1.0, variance[i] / ahead[i + 1]);
        mean[i] += gain * (mean[i + 1] - mean[i]);
      }
      amounts[members[i]].value = float(std::clamp(mean[i], low, high));
    }
  }
}

}  // namespace

LookPoints look_points(const HeadModel& model, std::span<const float> distance) {
  LookPoints points;
  for (std::size_t t = 0; t < model.triangles.size(); ++t) {
    const Triangle& triangle = model.triangles[t];
    const auto of = [&](int corner) { return distance[std::size_t(triangle[corner])]; };
    const float near = std::min({of(0), of(1), of(2)}), far = std::max({of(0), of(1), of(2)});
    auto* kind = far <= kPaintedWithin                     ? &points.region
                 : near >= kAroundFrom && far <= kAroundTo ? &points.around
                                                           : nullptr;
    if (!kind) continue;
    const float third = 1.f / 3;
    kind->push_back({int(t), {third, third, third}});
    for (int corner = 0; corner < 3; ++corner) {
      Vec3f towards = Vec3f::Constant(1.f / 6);
      towards[corner] = 2.f / 3;
      kind->push_back({int(t), towards});
    }
  }
  points.region = thinned(std::move(points.region)), points.around = thinned(std::move(points.around));
  return points;
}

FrameLook region_look(const HeadModel& model, std::span<const Vec3f> posed, const Camera& camera,
                      const Pose& world_from_head, const Image8& rgb, const LookPoints& points) {
  const Pose cam_from_head = camera.cam_from_world * world_from_head;
  const Sampler sampler{model,  posed,
                        camera, cam_from_head,
                        rgb,    rasterise(posed, model.triangles, camera.intrinsics, cam_from_head)};
  FrameLook look{Eigen::VectorXf::Zero(Eigen::Index(3 * points.region.size())),
                 std::vector<std::uint8_t>(points.region.size(), 0), 0};
  Vec3f light = Vec3f::Zero(), colour;
  float lit = 0;
  for (const LookPoints::Point& point : points.around)
    if (sampler.look(point, colour)) light += colour, ++lit;
  if (lit < 0.25f * float(points.around.size()) || points.region.empty()) return look;
  const Vec3f reference = ((light / std::max(1.f, lit)).array() + kNoLight).log();
  for (std::size_t i = 0; i < points.region.size(); ++i) {
    if (!sampler.look(points.region[i], colour)) continue;
    look.colours.segment<3>(Eigen::Index(3 * i)) = Vec3f((colour.array() + kNoLight).log()) - reference;
    look.seen[i] = 1, look.share += 1 / float(points.region.size());
  }
  return look;
}

bool can_regress(std::span<const LookedFrame> frames) {
  const auto taught = teaching(frames);
  return std::ranges::any_of(taught, [&](std::size_t i) {
    return std::abs(frames[i].value - frames[taught.front()].value) >= 0.05;
  });
}

AmountFit regress_amounts(std::span<const LookedFrame> frames) {
  LIKENESS_CHECK(can_regress(frames), "%zu frames", frames.size());
  const std::vector<std::size_t> annotated = teaching(frames);
  Vector values(Eigen::Index(annotated.size()));
  for (std::size_t i = 0; i < annotated.size(); ++i) values[Eigen::Index(i)] = frames[annotated[i]].value;

  const Looks looks = gather(frames);
  AmountFit fit;
  fit.frames.resize(frames.size());
  Matrix chosen;
  std::optional<Process> best;
  for (const bool without : {false, true}) {
    const Matrix colours = without ? without_aside(looks) : looks.colours;
    for (const double power : {0.0, 0.5, 1.0}) {
      const Matrix all = components_of(colours, looks.training, power);
      for (const double length : {0.0, 0.5, 1.0, 2.0, 4.0})
        for (const double noise : {0.05, 0.15, 0.3}) {
          Process process({length, noise}, rows_of(all, annotated), values);
          if (best && process.log_density <= best->log_density) continue;
          best.emplace(std::move(process));
          chosen = all, fit.without_aside = without;
        }
    }
  }
  fit.left_out_error = best->error;
  const Matrix plain =
      components_of(fit.without_aside ? without_aside(looks) : looks.colours, looks.training, 0);
  const std::vector<float> novelty = novelty_of(plain, annotated);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].look.share < kFewest) continue;
    fit.frames[i] = best->predict(chosen.row(Eigen::Index(i)));
    fit.frames[i].uncertainty = std::max(fit.frames[i].uncertainty, novelty[i]);
  }
  const auto as_said = [&] {
    for (std::size_t i = 0; i < frames.size(); ++i)
      if (frames[i].annotated) fit.frames[i] = {float(frames[i].value), 0};
  };
  as_said();
  smooth_runs(frames, best->kernel.noise, fit.frames);
  as_said();
  for (const FrameAmount& frame : fit.frames) fit.unlike_any += frame.uncertainty > kUnlikeAny;
  return fit;
}

}  // namespace likeness
