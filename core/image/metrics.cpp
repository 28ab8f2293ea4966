// Picture differences: see metrics.h.
//
// SSIM: Gaussian window of 11 x 11, sigma 1.5, only windows that lie inside the picture; C1 = 0.01^2, C2 =
// 0.03^2 for a dynamic range of 1; per channel, then the mean. GMSD: luma (BT.601), 2 x 2 mean and
// subsampling by 2, Prewitt gradients divided by 3, c = 170 / 255^2; standard deviation of the similarity
// map.
#include "core/image/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace likeness {
namespace {

void check_same_shape(const Image& a, const Image& b) {
  LIKENESS_CHECK(a.width == b.width && a.height == b.height && a.channels == b.channels,
                 "pictures differ in shape: %d x %d x %d against %d x %d x %d", a.width, a.height, a.channels,
                 b.width, b.height, b.channels);
}

double squared_difference(const float* a, const float* b, int channels) {
  double sum = 0;
  for (int c = 0; c < channels; ++c) {
    const double d = double(a[c]) - double(b[c]);
    sum += d * d;
  }
  return sum;
}

// The first and second moments that SSIM needs, in the order a, b, aa, bb, ab.
constexpr int kMoments = 5;
using Moments = std::array<float, kMoments>;

std::vector<float> gaussian_window(int radius) {
  std::vector<float> weights(2 * radius + 1);
  for (int i = -radius; i <= radius; ++i) weights[i + radius] = std::exp(-float(i * i) / (2 * 1.5f * 1.5f));
  const float sum = std::accumulate(weights.begin(), weights.end(), 0.0f);
  for (float& w : weights) w /= sum;
  return weights;
}

double ssim_of_moments(const Moments& m) {
  constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
  const double mean_a = m[0], mean_b = m[1];
  const double variance_a = m[2] - mean_a * mean_a, variance_b = m[3] - mean_b * mean_b;
  const double covariance = m[4] - mean_a * mean_b;
  return ((2 * mean_a * mean_b + c1) * (2 * covariance + c2)) /
         ((mean_a * mean_a + mean_b * mean_b + c1) * (variance_a + variance_b + c2));
}

double ssim_of_channel(const Image& a, const Image& b, int channel) {
  // A picture narrower than the window gets the largest window that fits.
  const int radius = std::min(5, (std::min(a.width, a.height) - 1) / 2);
  const std::vector<float> window = gaussian_window(radius);
  const int width = a.width, inner_width = width - 2 * radius, inner_height = a.height - 2 * radius;
  std::vector<double> row_sums(inner_height);
  parallel_ranges(std::size_t(inner_height), 8, [&](std::size_t begin, std::size_t end) {
    std::vector<Moments> columns(width);
    for (std::size_t y = begin; y < end; ++y) {
      std::fill(columns.begin(), columns.end(), Moments{});
      for (int k = 0; k <= 2 * radius; ++k) {
        const float *pa = a.at(0, int(y) + k) + channel, *pb = b.at(0, int(y) + k) + channel;
        for (int x = 0; x < width; ++x, pa += a.channels, pb += b.channels) {
          const float va = window[k] * *pa, vb = window[k] * *pb;
          Moments& m = columns[x];
          m[0] += va, m[1] += vb, m[2] += va * *pa, m[3] += vb * *pb, m[4] += va * *pb;
        }
      }
      double sum = 0;
      for (int x = 0; x < inner_width; ++x) {
        Moments m{};
        for (int k = 0; k <= 2 * radius; ++k) {
          for (int i = 0; i < kMoments; ++i) m[i] += window[k] * columns[x + k][i];
        }
        sum += ssim_of_moments(m);
      }
      row_sums[y] = sum;
    }
  });
  return std::accumulate(row_sums.begin(), row_sums.end(), 0.0) / (double(inner_width) * inner_height);
}

struct Plane {
  int width = 0, height = 0;
  std::vector<float> values;
  float at(int x, int y) const {
    // Outside counts as the nearest border value, so that a border makes no gradient of its own.
    return values[std::size_t(std::clamp(y, 0, height - 1)) * width + std::clamp(x, 0, width - 1)];
  }
};

Plane halved_luma(const Image& image) {
  Plane plane{std::max(image.width / 2, 1), std::max(image.height / 2, 1), {}};
  plane.values.reserve(std::size_t(plane.width) * plane.height);
  const auto luma = [&](int x, int y) {
    const float* p = image.at(std::min(x, image.width - 1), std::min(y, image.height - 1));
    return image.channels >= 3 ? 0.299f * p[0] + 0.587f * p[1] + 0.114f * p[2] : p[0];
  };
  for (int y = 0; y < plane.height; ++y) {
    for (int x = 0; x < plane.width; ++x) {
      plane.values.push_back(0.25f * (luma(2 * x, 2 * y) + luma(2 * x + 1, 2 * y) + luma(2 * x, 2 * y + 1) +
                                      luma(2 * x + 1, 2 * y + 1)));
    }
  }
  return plane;
}

double gradient_magnitude(const Plane& p, int x, int y) {
  double gx = 0, gy = 0;
  for (int k = -1; k <= 1; ++k) {
    gx += p.at(x + 1, y + k) - p.at(x - 1, y + k);
    gy += p.at(x + k, y + 1) - p.at(x + k, y - 1);
  }
  return std::sqrt(gx * gx + gy * gy) / 3;
}

}  // namespace

double mse(const Image& a, const Image& b) {
  check_same_shape(a, b);
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels(); ++i) {
    sum += squared_difference(a.data.data() + i * a.channels, b.data.data() + i * a.channels, a.channels);
  }
  return a.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / double(a.data.size());
}

double mse(const Image& a, const Image& b, const Image8& mask) {
  check_same_shape(a, b);
  LIKENESS_CHECK(mask.width == a.width && mask.height == a.height && mask.channels == 1,
                 "mask %d x %d x %d for a picture %d x %d", mask.width, mask.height, mask.channels, a.width,
                 a.height);
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.pixels(); ++i) {
    if (mask.data[i] == 0) continue;
    sum += squared_difference(a.data.data() + i * a.channels, b.data.data() + i * a.channels, a.channels);
    ++count;
  }
  return count == 0 ? std::numeric_limits<double>::quiet_NaN() : sum / (double(count) * a.channels);
}

double psnr_from_mse(double mse) {
  return mse == 0 ? std::numeric_limits<double>::infinity() : -10 * std::log10(mse);
}

double ssim(const Image& a, const Image& b) {
  check_same_shape(a, b);
  LIKENESS_CHECK(!a.empty(), "SSIM of an empty picture");
  double sum = 0;
  for (int c = 0; c < a.channels; ++c) sum += ssim_of_channel(a, b, c);
  return sum / a.channels;
}

double gmsd(const Image& a, const Image& b) {
  check_same_shape(a, b);
  LIKENESS_CHECK(!a.empty(), "GMSD of an empty picture");
  constexpr double c = 170.0 / (255.0 * 255.0);
  const Plane plane_a = halved_luma(a), plane_b = halved_luma(b);
  double sum = 0, squares = 0;
  for (int y = 0; y < plane_a.height; ++y) {
    for (int x = 0; x < plane_a.width; ++x) {
      const double ga = gradient_magnitude(plane_a, x, y), gb = gradient_magnitude(plane_b, x, y);
      const double similarity = (2 * ga * gb + c) / (ga * ga + gb * gb + c);
      sum += similarity, squares += similarity * similarity;
    }
  }
  const double count = double(plane_a.values.size()), mean = sum / count;
  return std::sqrt(std::max(0.0, squares / count - mean * mean));
}

}  // namespace likeness
