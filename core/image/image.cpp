// Conversions, crop and separable resampling of pictures: see image.h.
#include "core/image/image.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace likeness {

Image to_float(const Image8& image) {
  Image result(image.width, image.height, image.channels);
  std::transform(image.data.begin(), image.data.end(), result.data.begin(),
                 [](std::uint8_t v) { return float(v) * (1.0f / 255.0f); });
  return result;
}

Image8 to_bytes(const Image& image) {
  Image8 result(image.width, image.height, image.channels);
  std::transform(image.data.begin(), image.data.end(), result.data.begin(), [](float v) {
    // Written so that a NaN becomes 0 rather than an undefined conversion.
    return v > 0 ? std::uint8_t(std::min(v, 1.0f) * 255.0f + 0.5f) : std::uint8_t(0);
  });
  return result;
}

Image8 crop(const Image8& image, int x, int y, int width, int height) {
  LIKENESS_CHECK(!image.empty() && width > 0 && height > 0, "crop %d x %d of a picture %d x %d", width,
                 height, image.width, image.height);
  Image8 result(width, height, image.channels);
  const int inside_begin = std::clamp(-x, 0, width),
            inside_end = std::clamp(image.width - x, inside_begin, width);
  for (int row = 0; row < height; ++row) {
    const int source_row = std::clamp(y + row, 0, image.height - 1);
    for (int column = 0; column < inside_begin; ++column) {
      std::copy_n(image.at(std::min(0, image.width - 1), source_row), image.channels, result.at(column, row));
    }
    if (inside_end > inside_begin) {
      std::copy_n(image.at(x + inside_begin, source_row),
                  std::size_t(inside_end - inside_begin) * image.channels, result.at(inside_begin, row));
    }
    for (int column = inside_end; column < width; ++column) {
      std::copy_n(image.at(image.width - 1, source_row), image.channels, result.at(column, row));
    }
  }
  return result;
}

Image8 crop(const Image8& image, const PixelRect& part) {
  return part.empty() ? image : crop(image, part.x, part.y, part.width, part.height);
}

void fill_outside(Image8& image, const PixelRect& inside, std::uint8_t level) {
  if (inside.empty()) return;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (!inside.contains(x, y)) std::fill_n(image.at(x, y), image.channels, level);
}

namespace {

// One output sample of a one-dimensional filter: source samples [first, first + count) times weights.
struct Tap {
  int first = 0, count = 0;
  std::size_t weights = 0;  // offset into AxisFilter::weights
};
struct AxisFilter {
  std::vector<Tap> taps;       // one per output sample
  std::vector<float> weights;  // of each tap they sum to 1
};

// Shrinking: exact coverage of the output sample's interval. Enlarging: linear between sample centres.
AxisFilter axis_filter(int source, int target) {
  AxisFilter filter;
  const double step = double(source) / target;
  for (int i = 0; i < target; ++i) {
    Tap tap{0, 0, filter.weights.size()};
    if (target < source) {
      const double begin = i * step, end = (i + 1) * step;
      tap.first = int(begin);
      const int last = std::min(int(std::ceil(end)), source);
      for (int s = tap.first; s < last; ++s) {
        filter.weights.push_back(float((std::min(end, s + 1.0) - std::max(begin, double(s))) / step));
      }
    } else {
      const double centre = std::clamp((i + 0.5) * step - 0.5, 0.0, source - 1.0);
      tap.first = std::min(int(centre), std::max(source - 2, 0));
      const double share = centre - tap.first;
      filter.weights.push_back(float(1 - share));
      if (source > 1) filter.weights.push_back(float(share));
    }
    tap.count = int(filter.weights.size() - tap.weights);
    filter.taps.push_back(tap);
  }
  return filter;
}

// Weighted sum of source rows into one row of width * channels floats.
void blend_rows(const Image8& image, const AxisFilter& filter, const Tap& tap, std::vector<float>& row) {
  const std::size_t length = std::size_t(image.width) * image.channels;
  std::fill(row.begin(), row.end(), 0.0f);
  for (int k = 0; k < tap.count; ++k) {
    const float weight = filter.weights[tap.weights + k];
    const std::uint8_t* source = image.at(0, tap.first + k);
    for (std::size_t i = 0; i < length; ++i) row[i] += weight * float(source[i]);
  }
}

template <int kChannels>
void blend_columns(const std::vector<float>& row, const AxisFilter& filter, std::uint8_t* target) {
  for (const Tap& tap : filter.taps) {
    float sum[kChannels] = {};
    const float* source = row.data() + std::size_t(tap.first) * kChannels;
    for (int k = 0; k < tap.count; ++k) {
      const float weight = filter.weights[tap.weights + k];
      for (int c = 0; c < kChannels; ++c) sum[c] += weight * *source++;
    }
    for (int c = 0; c < kChannels; ++c) *target++ = std::uint8_t(std::min(sum[c] + 0.5f, 255.0f));
  }
}

}  // namespace

namespace {

// Four neighbours of a place along an axis, and their weights.
struct SplineTap {
  int at[4];
  float weight[4];
};

std::vector<SplineTap> spline_taps(int from, int to) {
  std::vector<SplineTap> taps(static_cast<std::size_t>(to));
  for (int i = 0; i < to; ++i) {
    const double x = (i + 0.5) * from / to - 0.5;
    const int base = int(std::floor(x));
    const auto t = float(x - base);
    SplineTap& tap = taps[std::size_t(i)];
    for (int k = 0; k < 4; ++k) tap.at[k] = std::clamp(base - 1 + k, 0, from - 1);
    tap.weight[0] = t * (-0.5f + t * (1 - 0.5f * t));
    tap.weight[1] = 1 + t * t * (-2.5f + 1.5f * t);
    tap.weight[2] = t * (0.5f + t * (2 - 1.5f * t));
    tap.weight[3] = t * t * (-0.5f + 0.5f * t);
  }
  return taps;
}

// out[i]: the four rows' numbers i by the tap's weights, held within their range.
void spline_rows(const SplineTap& tap, const std::array<const float*, 4>& rows, std::size_t count,
                 float* out) {
  const auto [a, b, c, d] = rows;
  for (std::size_t i = 0; i < count; ++i) {
    const float sum =
        tap.weight[0] * a[i] + tap.weight[1] * b[i] + tap.weight[2] * c[i] + tap.weight[3] * d[i];
    const float low = std::min(std::min(a[i], b[i]), std::min(c[i], d[i])),
                high = std::max(std::max(a[i], b[i]), std::max(c[i], d[i]));
    out[i] = std::min(std::max(sum, low), high);
  }
}

std::array<const float*, 4> tapped(const SplineTap& tap, const float* values, std::size_t stride) {
  std::array<const float*, 4> rows;
  for (std::size_t k = 0; k < 4; ++k) rows[k] = values + std::size_t(tap.at[k]) * stride;
  return rows;
}

// kChannels numbers at a time: as a compile-time constant, they make one instruction.
template <std::size_t kChannels>
void spline_across(const std::vector<SplineTap>& taps, const float* values, float* out) {
  for (const SplineTap& tap : taps) {
    float sum[kChannels];
    spline_rows(tap, tapped(tap, values, kChannels), kChannels, sum);
    for (std::size_t c = 0; c < kChannels; ++c) *out++ = sum[c];
  }
}

}  // namespace

Image enlarge(const Image& image, int width, int height) {
  LIKENESS_CHECK(!image.empty() && width >= image.width && height >= image.height,
                 "enlarging %d x %d to %d x %d", image.width, image.height, width, height);
  LIKENESS_CHECK(image.channels >= 1 && image.channels <= 4, "enlarging %d channels", image.channels);
  const std::vector<SplineTap> across = spline_taps(image.width, width),
                               down = spline_taps(image.height, height);
  const auto channels = std::size_t(image.channels), row = std::size_t(image.width) * channels;
  Image result(width, height, image.channels);
  parallel_ranges(std::size_t(height), 16, [&](std::size_t begin, std::size_t end) {
    std::vector<float> between(row);
    for (std::size_t y = begin; y < end; ++y) {
      spline_rows(down[y], tapped(down[y], image.data.data(), row), row, between.data());
      float* const out = result.at(0, int(y));
      switch (channels) {
        case 1:
          spline_across<1>(across, between.data(), out);
          break;
        case 2:
          spline_across<2>(across, between.data(), out);
          break;
        case 3:
          spline_across<3>(across, between.data(), out);
          break;
        default:
          spline_across<4>(across, between.data(), out);
      }
    }
  });
  return result;
}

Image8 resize(const Image8& image, int width, int height) {
  LIKENESS_CHECK(!image.empty() && width > 0 && height > 0, "resize of %d x %d to %d x %d", image.width,
                 image.height, width, height);
  LIKENESS_CHECK(image.channels >= 1 && image.channels <= 4, "resize of %d channels", image.channels);
  if (width == image.width && height == image.height) return image;
  const AxisFilter horizontal = axis_filter(image.width, width), vertical = axis_filter(image.height, height);
  Image8 result(width, height, image.channels);
  parallel_ranges(std::size_t(height), 16, [&](std::size_t begin, std::size_t end) {
    std::vector<float> row(std::size_t(image.width) * image.channels);
    for (std::size_t y = begin; y < end; ++y) {
      blend_rows(image, vertical, vertical.taps[y], row);
      std::uint8_t* target = result.at(0, int(y));
      switch (image.channels) {
        case 1:
          blend_columns<1>(row, horizontal, target);
          break;
        case 2:
          blend_columns<2>(row, horizontal, target);
          break;
        case 3:
          blend_columns<3>(row, horizontal, target);
          break;
        default:
          blend_columns<4>(row, horizontal, target);
      }
    }
  });
  return result;
}

}  // namespace likeness
