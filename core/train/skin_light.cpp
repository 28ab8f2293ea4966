// Ridge regression, reweighted.
#include "core/train/skin_light.h"

#include <algorithm>
#include <cmath>

#include "core/base/dense_solves.h"

namespace likeness {
namespace {

constexpr int kReweightings = 4;
constexpr double kRidge = 0.01, kOutlier = 0.15;          // of the weights' sum; of the usual colour
constexpr float kSidemost = 0.2f;                         // cosine of normal and front
constexpr float kFewestSeen = 100;                        // places
constexpr float kDarkestSkin = 0.25f, kLightestSkin = 2;  // of the usual colour

using Harmonics = Eigen::Matrix<double, 9, 1>;
Harmonics harmonics(const Vec3f& normal) {
  const double x = normal.x(), y = normal.y(), z = normal.z();
  Harmonics h;
  h << 1, x, y, z, x * y, y * z, x * z, x * x - y * y, 3 * z * z - 1;
  return h;
}

Vec3f towards_front(const SkinLight& light, const Vec3f& normal) {
  const float facing = normal.dot(light.front);
  if (facing >= kSidemost) return normal;
  const Vec3f aside = normal - facing * light.front;
  if (aside.norm() < 1e-3f) return light.front;
  return kSidemost * light.front + std::sqrt(1 - kSidemost * kSidemost) * aside.normalized();
}

}  // namespace

SkinLight fit_light(const std::vector<Vec3f>& normals, const std::vector<Vec3f>& colours,
                    const std::vector<float>& weights) {
  SkinLight light;
  Vec3f sum = Vec3f::Zero(), front = Vec3f::Zero();
  float weight = 0;
  for (std::size_t v = 0; v < weights.size(); ++v)
    sum += weights[v] * colours[v], front += weights[v] * normals[v], weight += weights[v];
  if (weight > 0) light.usual = sum / weight;
  if (front.norm() > 0) light.front = front.normalized();
  light.coefficients.row(0) = light.usual.transpose();
  if (weight < kFewestSeen) return light;
  for (int round = 0; round < kReweightings; ++round) {
    Eigen::MatrixXd normal_matrix = Eigen::MatrixXd::Zero(9, 9), right = Eigen::MatrixXd::Zero(9, 3);
    double total = 0;
    for (std::size_t v = 0; v < weights.size(); ++v) {
      if (weights[v] <= 0) continue;
      const Harmonics h = harmonics(normals[v]);
      double w = weights[v];
      if (round > 0) {
        const Vec3f expected = light.coefficients.transpose() * h.cast<float>();
        const double off = (colours[v] - expected).norm() / (kOutlier * std::max(1e-3f, light.usual.norm()));
        w /= 1 + off * off;
      }
      normal_matrix += w * h * h.transpose();
      right += w * h * colours[v].cast<double>().transpose();
      total += w;
    }
    for (int i = 1; i < 9; ++i) normal_matrix(i, i) += kRidge * total;
    light.coefficients = solve_symmetric_columns(normal_matrix, right).cast<float>();
  }
  return light;
}

Vec3f shade(const SkinLight& light, const Vec3f& normal) {
  const Vec3f colour = light.coefficients.transpose() * harmonics(towards_front(light, normal)).cast<float>();
  return colour.cwiseMax(kDarkestSkin * light.usual).cwiseMin(kLightestSkin * light.usual);
}

}  // namespace likeness
