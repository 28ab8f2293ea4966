// Slow sums of sines, and a separable Gaussian.
#include "core/synth/drift.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/synth/noise.h"

namespace likeness {
namespace {

constexpr double kLongest_s = 12;  // of a wander, up and down again

// A slow curve in [-1, 1]: in a short clip one period, in a long one periods of at most kLongest_s.
float wander(const DemoOptions& options, int frame, std::uint32_t what) {
  const double seconds = options.frames / options.frames_per_second;
  const double t = frame / options.frames_per_second / std::min(seconds, kLongest_s);
  const std::uint32_t seed = hash_u32(std::uint32_t(options.seed) + 5100 + what);
  const double a = hash_unit(seed), b = hash_unit(seed + 1), c = hash_unit(seed + 2);
  const double turn = 2 * std::numbers::pi;
  return float((std::sin(turn * (t + a)) + 0.3 * std::sin(turn * (1.7 * t + b)) +
                0.15 * std::sin(turn * (2.9 * t + c))) /
               1.45);
}

std::vector<float> gaussian(float sigma) {
  const int reach = std::max(1, int(std::ceil(3 * sigma)));
  std::vector<float> weights(std::size_t(2 * reach + 1));
  float sum = 0;
  for (int i = -reach; i <= reach; ++i)
    sum += weights[std::size_t(i + reach)] = std::exp(-0.5f * float(i * i) / (sigma * sigma));
  for (float& w : weights) w /= sum;
  return weights;
}

template <class T>
void blur(std::vector<T>& layer, int width, int height, float sigma, const T& zero) {
  LIKENESS_CHECK(layer.size() == std::size_t(width) * std::size_t(height), "%zu values for %d x %d",
                 layer.size(), width, height);
  if (sigma <= 0.05f) return;
  const std::vector<float> weights = gaussian(sigma);
  const int reach = int(weights.size() / 2);
  std::vector<T> across(layer.size(), zero);
  const auto at = [&](int x, int y) { return std::size_t(y) * std::size_t(width) + std::size_t(x); };
  parallel_for(std::size_t(height), [&](std::size_t y) {
    for (int x = 0; x < width; ++x)
      for (int i = -reach; i <= reach; ++i)
        across[at(x, int(y))] +=
            weights[std::size_t(i + reach)] * layer[at(std::clamp(x + i, 0, width - 1), int(y))];
  });
  parallel_for(std::size_t(height), [&](std::size_t y) {
    for (int x = 0; x < width; ++x) {
      T sum = zero;
      for (int i = -reach; i <= reach; ++i)
        sum += weights[std::size_t(i + reach)] * across[at(x, std::clamp(int(y) + i, 0, height - 1))];
      layer[at(x, int(y))] = sum;
    }
  });
}

}  // namespace

Drift drift_of(const DemoOptions& options, int frame) {
  Drift drift;
  if (!options.drift) return drift;
  const float exposure = 1 + kExposureDrift * wander(options, frame, 0);
  const float warmth = kWhiteDrift * wander(options, frame, 10),
              tint = 0.4f * kWhiteDrift * wander(options, frame, 20);
  drift.gain = exposure * Vec3f(1 + warmth, 1 + tint, 1 - warmth);
  const float focus = wander(options, frame, 30);  // 1: on the room, -1: on the face
  drift.face_blur_px = kFocusDrift_px * std::max(0.0f, focus);
  drift.room_blur_px = kFocusDrift_px * std::clamp(0.5f - 0.5f * focus, 0.0f, 1.0f);
  return drift;
}

void blur_layer(std::vector<Vec3f>& layer, int width, int height, float sigma_px) {
  blur<Vec3f>(layer, width, height, sigma_px, Vec3f::Zero());
}
void blur_layer(std::vector<float>& layer, int width, int height, float sigma_px) {
  blur<float>(layer, width, height, sigma_px, 0.0f);
}

}  // namespace likeness
