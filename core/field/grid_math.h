// Look-ups in the levels of a grid, and their gradients, for one sample. A device sums the gradients of a
// warp's samples before it adds them (encode.cu); otherwise its threads run this code. Plain C++17.
// Dimensions and features are compile-time constants, so that everything stays in registers.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/field/device_kernels.h"
#include "core/field/device_math.h"

namespace likeness {

// A corner's features, read whole.
template <int kFeatures>
struct alignas(kFeatures == 8 ? 16 : 4 * kFeatures) GridEntry {
  float value[kFeatures];
};

template <int kDims>
struct GridCell {
  float part[kDims];   // position within the cell, 0..1
  float slope[kDims];  // derivative of the part: 0 where it was clamped
  std::uint32_t vertex[kDims];

  LIKENESS_HOST_DEVICE GridCell(const GridLevel& level, const float* const* point, std::size_t n) {
    for (int a = 0; a < kDims; ++a) {
      const float x = point[a][n], scale = float(level.resolution);
      const float inside = fminf(fmaxf(x, 0.0f), 1.0f);
      const int below = int(inside * scale), last = level.resolution - 1, cell = below < last ? below : last;
      vertex[a] = std::uint32_t(cell);
      part[a] = fmaf(inside, scale, -float(cell));  // rounded once: cells are many, and parts small
      slope[a] = x >= 0 && x <= 1 ? scale : 0.0f;
    }
  }
  LIKENESS_HOST_DEVICE std::uint32_t entry(const GridLevel& level, int corner) const {
    std::uint32_t at = 0;
    for (int a = 0; a < kDims; ++a) {
      const std::uint32_t v = vertex[a] + std::uint32_t(corner >> a & 1);
      const std::uint32_t prime = a == 0 ? 1u : a == 1 ? kHashPrimeY : kHashPrimeZ;
      at = level.hashed ? at ^ v * prime : at + v * level.stride[a];
    }
    return level.hashed ? at & level.mask : at;
  }
  LIKENESS_HOST_DEVICE float side(int corner, int a) const { return corner >> a & 1 ? part[a] : 1 - part[a]; }
  LIKENESS_HOST_DEVICE float weight(int corner) const {
    float product = 1;
    for (int a = 0; a < kDims; ++a) product *= side(corner, a);
    return product;
  }
  // Derivative of the corner's weight with respect to coordinate a.
  LIKENESS_HOST_DEVICE float weight_slope(int corner, int a) const {
    float product = corner >> a & 1 ? slope[a] : -slope[a];
    for (int b = 0; b < kDims; ++b)
      if (b != a) product *= side(corner, b);
    return product;
  }
};

template <int kDims, int kFeatures>
LIKENESS_HOST_DEVICE void encode_sample(const EncodeArgs& args, std::size_t n, int l) {
  const GridLevel& level = args.grid.level[l];
  const GridCell<kDims> cell(level, args.point, n);
  const auto* table = reinterpret_cast<const GridEntry<kFeatures>*>(args.parameters + level.offset);
  float sum[kFeatures] = {};
#ifdef __CUDA_ARCH__
#pragma unroll
#endif
  for (int c = 0; c < 1 << kDims; ++c) {
    const GridEntry<kFeatures> entry = table[cell.entry(level, c)];
    const float weight = cell.weight(c);
    for (int f = 0; f < kFeatures; ++f) sum[f] += weight * entry.value[f];
  }
  for (int f = 0; f < kFeatures; ++f)
    args.features[(std::size_t(l) * kFeatures + f) * args.capacity + n] = sum[f];
}

// Gradient of a sample's features in a level; false: all zero, and the sample adds nothing.
template <int kFeatures>
LIKENESS_HOST_DEVICE bool level_gradient(const EncodeBackwardArgs& args, std::size_t n, int l,
                                         float (&gradient)[kFeatures]) {
  bool any = false;
  for (int f = 0; f < kFeatures; ++f) {
    gradient[f] = args.d_features[(std::size_t(l) * kFeatures + f) * args.capacity + n];
    any = any || gradient[f] != 0;
  }
  return any;
}

// Adds to the table's gradient.
template <int kDims, int kFeatures>
LIKENESS_HOST_DEVICE void add_gradients(const EncodeBackwardArgs& args, const GridLevel& level,
                                        const GridCell<kDims>& cell, const float (&gradient)[kFeatures]) {
#ifdef __CUDA_ARCH__
#pragma unroll
#endif
  for (int c = 0; c < 1 << kDims; ++c) {
    const float weight = cell.weight(c);
    if (weight == 0) continue;
    float own[kFeatures];
    for (int f = 0; f < kFeatures; ++f) own[f] = weight * gradient[f];
    add_entry(args.gradients + level.offset + std::size_t(cell.entry(level, c)) * kFeatures, own);
  }
}

// Adds to the point's gradient.
template <int kDims, int kFeatures>
LIKENESS_HOST_DEVICE void add_slopes(const EncodeBackwardArgs& args, const GridLevel& level,
                                     const GridCell<kDims>& cell, const float (&gradient)[kFeatures],
                                     float* d_point) {
  const auto* table = reinterpret_cast<const GridEntry<kFeatures>*>(args.parameters + level.offset);
#ifdef __CUDA_ARCH__
#pragma unroll
#endif
  for (int c = 0; c < 1 << kDims; ++c) {
    const GridEntry<kFeatures> entry = table[cell.entry(level, c)];
    float dot = 0;
    for (int f = 0; f < kFeatures; ++f) dot += entry.value[f] * gradient[f];
    for (int a = 0; a < kDims; ++a) d_point[a] += cell.weight_slope(c, a) * dot;
  }
}

// Gradients of one level for a sample; d_point: or null.
template <int kDims, int kFeatures>
LIKENESS_HOST_DEVICE void encode_sample_backward(const EncodeBackwardArgs& args, std::size_t n, int l,
                                                 float* d_point) {
  float gradient[kFeatures];
  if (!level_gradient(args, n, l, gradient)) return;
  const GridLevel& level = args.grid.level[l];
  const GridCell<kDims> cell(level, args.point, n);
  add_gradients(args, level, cell, gradient);
  if (d_point) add_slopes(args, level, cell, gradient, d_point);
}

// Through all levels, with the slopes of the point.
template <int kDims, int kFeatures>
LIKENESS_HOST_DEVICE void encode_sample_slopes(const EncodeBackwardArgs& args, std::size_t n) {
  float d_point[kDims] = {};
  for (int l = 0; l < args.grid.levels; ++l) encode_sample_backward<kDims, kFeatures>(args, n, l, d_point);
  for (int a = 0; a < kDims; ++a) args.d_point[a][n] = d_point[a];
}

// CALL(dimensions, features) of the grid; nothing if there is no such grid.
#define LIKENESS_FOR_GRID(grid, CALL)                 \
  switch ((grid).dimensions * 10 + (grid).features) { \
    case 11:                                          \
      CALL(1, 1) break;                               \
    case 12:                                          \
      CALL(1, 2) break;                               \
    case 14:                                          \
      CALL(1, 4) break;                               \
    case 18:                                          \
      CALL(1, 8) break;                               \
    case 21:                                          \
      CALL(2, 1) break;                               \
    case 22:                                          \
      CALL(2, 2) break;                               \
    case 24:                                          \
      CALL(2, 4) break;                               \
    case 28:                                          \
      CALL(2, 8) break;                               \
    case 31:                                          \
      CALL(3, 1) break;                               \
    case 32:                                          \
      CALL(3, 2) break;                               \
    case 34:                                          \
      CALL(3, 4) break;                               \
    case 38:                                          \
      CALL(3, 8) break;                               \
    default:                                          \
      break;                                          \
  }

}  // namespace likeness
