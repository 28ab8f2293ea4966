#include "core/track/photo/lighting.h"

#include <algorithm>
#include <cmath>

#include "core/base/dense_solves.h"
#include "core/image/srgb.h"

namespace likeness {
namespace {

constexpr double kDarkest = 0.05;                       // of the mean light
constexpr double kOutlier = 0.15;                       // relative error from which a sample counts half
constexpr double kAlternations = 6;                     // albedo, light, weights
constexpr double kLightPrior = 0.02;                    // of the samples' weight, towards even light
constexpr int kMinPictures = 3;                         // in which a point must be seen
constexpr float kMinSpread = 3.0f, kMaxSpread = 60.0f;  // encoded levels

// Weight of a relative error; falls with its square, so that a glint has no influence.
double trust(double error) {
  const double t = error / kOutlier;
  return 1 / ((1 + t * t) * (1 + t * t));
}

}  // namespace

ShVector sh_basis(const Vec3d& n) {
  ShVector b;
  b << 1, n.x(), n.y(), n.z(), n.x() * n.y(), n.y() * n.z(), n.z() * n.x(), n.x() * n.x() - n.y() * n.y(),
      3 * n.z() * n.z() - 1;
  return b;
}

double shade(const ShVector& light, const Vec3d& normal) {
  return std::max(kDarkest, light.dot(sh_basis(normal)));
}

double linear_of_encoded(double level) { return linear_of_srgb(level / 255); }

double encoded_of_linear(double value) { return 255 * srgb_of_linear(value); }

LitPoints light_points(const std::vector<std::vector<LightSample>>& pictures, int points,
                       const ShVector* fixed_light) {
  LitPoints lit;
  lit.light[0] = 1;
  if (fixed_light) lit.light = *fixed_light;
  std::vector<double> albedo(points, 0), top(points), bottom(points);
  std::vector<int> seen(points, 0);
  for (const auto& picture : pictures)
    for (const LightSample& s : picture) ++seen[s.point];
  for (int round = 0; round < kAlternations; ++round) {
    // -- Albedo under the current light.
    std::fill(top.begin(), top.end(), 0.0);
    std::fill(bottom.begin(), bottom.end(), 0.0);
    for (const auto& picture : pictures)
      for (const LightSample& s : picture) {
        const double light = shade(lit.light, s.normal.cast<double>());
        const double now = albedo[s.point] * light;
        const double w = s.weight * (round == 0 ? 1.0 : trust((s.linear - now) / std::max(0.02, now)));
        top[s.point] += w * s.linear * light;
        bottom[s.point] += w * light * light;
      }
    for (int p = 0; p < points; ++p) albedo[p] = bottom[p] > 0 ? top[p] / bottom[p] : 0;
    if (fixed_light || round + 1 == kAlternations) continue;
    // -- Light under the current albedo.
    Eigen::Matrix<double, 9, 9> hessian = Eigen::Matrix<double, 9, 9>::Zero();
    ShVector right = ShVector::Zero(), mean = ShVector::Zero();
    double weight = 0, mean_albedo2 = 0;
    for (const auto& picture : pictures)
      for (const LightSample& s : picture) {
        const ShVector b = sh_basis(s.normal.cast<double>());
        const double a = albedo[s.point], now = a * std::max(kDarkest, lit.light.dot(b));
        const double w = s.weight * trust((s.linear - now) / std::max(0.02, now));
        hessian.noalias() += w * a * a * b * b.transpose();
        right += w * a * s.linear * b;
        mean += w * b;
        weight += w;
        mean_albedo2 += w * a * a;
      }
    if (weight <= 0) break;
    const double prior = kLightPrior * mean_albedo2;
    hessian.diagonal().array() += prior;
    right[0] += prior;  // towards even light of strength 1
    const ShVector light = solve_symmetric<9>(hessian, right);
    const double level = light.dot(mean) / weight;
    if (!light.allFinite() || level <= 0) break;
    lit.light = light / level;
  }
  // -- The residuals.
  std::vector<double> error2(points, 0), total(points, 0);
  for (const auto& picture : pictures)
    for (const LightSample& s : picture) {
      const double now = albedo[s.point] * shade(lit.light, s.normal.cast<double>());
      const double e = std::min(80.0, std::abs(encoded_of_linear(s.linear) - encoded_of_linear(now)));
      error2[s.point] += s.weight * e;
      total[s.point] += s.weight;
    }
  lit.albedo.assign(points, 0);
  lit.spread.assign(points, kMaxSpread);
  for (int p = 0; p < points; ++p) {
    if (seen[p] < kMinPictures || total[p] <= 0 || albedo[p] <= 0) continue;
    lit.albedo[p] = static_cast<float>(albedo[p]);
    // 1.25: from the mean of absolute values to a standard deviation
    lit.spread[p] = std::clamp(static_cast<float>(1.25 * error2[p] / total[p]), kMinSpread, kMaxSpread);
  }
  return lit;
}

}  // namespace likeness
