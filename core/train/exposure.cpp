// Ratios of linear light: see exposure.h.
#include "core/train/exposure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/image/srgb.h"

namespace likeness {
namespace {

constexpr int kExposureEvery = 2;  // pixels along an axis
constexpr std::uint8_t kExposureSurelyWall = 3, kExposureSeenWall = 250;
constexpr std::uint8_t kDark = 12, kBright = 243;  // beyond, noise or clipping say more than the light
constexpr double kExposureEnoughWall = 0.01;       // of the pixels looked at
constexpr float kMostExposure = 4;
constexpr float kExposureNear = 0.15f;  // of the usual ratio: what differs more is a shadow or a passer-by

using LightTable = std::array<float, 256>;

const LightTable& light_table() {
  static const LightTable table = [] {
    LightTable light{};
    for (std::size_t v = 0; v < light.size(); ++v) light[v] = linear_of_srgb(float(v) / 255);
    return light;
  }();
  return table;
}

bool tells(std::uint8_t level) { return level >= kDark && level <= kBright; }

}  // namespace

std::optional<Vec3f> exposure_beside(const Image8& picture, const TiledMask& alpha,
                                     const PlatePicture& behind) {
  if (picture.empty() || alpha.empty() || behind.rgb.empty()) return std::nullopt;
  const LightTable& light = light_table();
  std::array<std::vector<std::pair<float, float>>, 3> pairs;  // light in the picture, in the plate
  std::size_t looked_at = 0;
  for (int y = 0; y < picture.height; y += kExposureEvery)
    for (int x = 0; x < picture.width; x += kExposureEvery, ++looked_at) {
      if (alpha.at(x, y) > kExposureSurelyWall) continue;
      if (!behind.known.empty() && behind.known.at(x, y)[0] < kExposureSeenWall) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint8_t seen = picture.at(x, y)[c], plate = behind.rgb.at(x, y)[c];
        if (tells(seen) && tells(plate)) pairs[c].emplace_back(light[seen], light[plate]);
      }
    }
  Vec3f exposure;
  for (std::size_t c = 0; c < 3; ++c) {
    if (double(pairs[c].size()) < kExposureEnoughWall * double(looked_at)) return std::nullopt;
    std::vector<float> ratios;
    for (const auto& [seen, plate] : pairs[c]) ratios.push_back(seen / plate);
    const float usual = median(std::move(ratios));
    // Levels are rounded: sums of those near the median are finer than the median.
    float seen_sum = 0, plate_sum = 0;
    for (const auto& [seen, plate] : pairs[c])
      if (std::abs(seen - usual * plate) <= kExposureNear * usual * plate)
        seen_sum += seen, plate_sum += plate;
    exposure[Eigen::Index(c)] = std::clamp(seen_sum / plate_sum, 1 / kMostExposure, kMostExposure);
  }
  return exposure;
}

Image8 exposed(const Image8& picture, const Vec3f& factor) {
  std::array<std::array<std::uint8_t, 256>, 3> tables;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t v = 0; v < 256; ++v) {
      const float stored = srgb_of_linear(light_table()[v] * factor[Eigen::Index(c)]);
      tables[c][v] = std::uint8_t(std::lround(255 * std::clamp(stored, 0.0f, 1.0f)));
    }
  Image8 out = picture;
  for (std::size_t i = 0; i < out.data.size(); ++i) out.data[i] = tables[i % 3][out.data[i]];
  return out;
}

Image exposed(Image picture, const Vec3f& factor) {
  if (factor == Vec3f::Ones()) return picture;
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    const float light = linear_of_srgb(std::max(0.0f, picture.data[i])) * factor[Eigen::Index(i % 3)];
    picture.data[i] = std::min(1.0f, srgb_of_linear(light));
  }
  return picture;
}

std::vector<Vec3f> view_exposures(const TrainingSet& set) {
  const std::span<const TrainingView> own = own_views(set);
  std::vector<std::optional<Vec3f>> told(own.size());
  parallel_for(own.size(), [&](std::size_t v) {
    if (own[v].has_plate && !set.plate.empty())
      told[v] = exposure_beside(own[v].rgb, own[v].alpha, plate_picture(set, own[v]));
  });
  std::vector<Vec3f> exposures(own.size(), Vec3f::Ones());
  std::optional<std::size_t> before;
  for (std::size_t v = 0; v < own.size(); ++v) {
    if (!told[v]) continue;
    exposures[v] = *told[v];
    for (std::size_t k = before ? *before + 1 : 0; k < v; ++k) {
      if (!before) {
        exposures[k] = *told[v];
        continue;
      }
      const auto frame = [&](std::size_t i) { return float(own[i].camera.frame); };
      const float share = (frame(k) - frame(*before)) / std::max(1.0f, frame(v) - frame(*before));
      exposures[k] = (1 - share) * *told[*before] + share * *told[v];
    }
    before = v;
  }
  for (std::size_t k = before ? *before + 1 : own.size(); k < own.size(); ++k) exposures[k] = *told[*before];
  return exposures;
}

std::optional<double> exposure_drift(const std::vector<Vec3f>& exposures) {
  if (exposures.size() < 2) return std::nullopt;
  const double n = double(exposures.size());
  Vec3d mean = Vec3d::Zero();
  for (const Vec3f& exposure : exposures) mean += exposure.array().log().matrix().cast<double>() / n;
  double squares = 0;
  for (const Vec3f& exposure : exposures)
    squares += (exposure.array().log().matrix().cast<double>() - mean).squaredNorm() / (3 * n);
  return std::sqrt(squares);
}

void even_exposure(const std::vector<Vec3f>& exposures, TrainingSet& set) {
  const std::size_t own = own_views(set).size();
  LIKENESS_CHECK(exposures.size() == own, "%zu exposures of %zu views", exposures.size(), own);
  parallel_for(
      own, [&](std::size_t v) { set.views[v].rgb = exposed(set.views[v].rgb, exposures[v].cwiseInverse()); });
}

}  // namespace likeness
