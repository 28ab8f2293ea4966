// A loss that sees a patch of rays as a whole: the L1 norm of a linear map of the errors of its grey values.
// What the map measures is up to its owner (core/train/landmark_patches.h: where a landmark lies).
//
//   L = weight sum_o | sum_i map[o, i] grey(rendered_i - true_i) |
#pragma once

#include <cstddef>
#include <span>

namespace likeness {

// Of sRGB-encoded red, green and blue: the luma of ITU-R BT.601.
inline constexpr float kGreyOfRgb[3] = {0.299f, 0.587f, 0.114f};

// Rays [first, first + count) of a batch.
struct RayPatch {
  std::size_t first = 0, count = 0;
  int landmark = 0;
  float weight = 0;
  std::span<const float> map;  // (2, count) per grey level of [0, 1]; owned elsewhere, and outliving this
};

// difference: (n, 3) rendered - true; d_difference: (n, 3) is set to dL / d difference. Where a row of the
// map gives exactly zero, its slope is zero.
template <class T>
T patch_loss(std::span<const float> map, T weight, std::span<const T> difference, std::span<T> d_difference) {
  const std::size_t rays = difference.size() / 3, rows = rays == 0 ? 0 : map.size() / rays;
  T loss = 0;
  for (T& slope : d_difference) slope = 0;
  for (std::size_t o = 0; o < rows; ++o) {
    const std::span<const float> row = map.subspan(o * rays, rays);
    T sum = 0;
    for (std::size_t i = 0; i < rays; ++i)
      for (std::size_t c = 0; c < 3; ++c) sum += T(row[i]) * T(kGreyOfRgb[c]) * difference[3 * i + c];
    const T side = sum > 0 ? weight : sum < 0 ? -weight : T(0);
    loss += side * sum;
    for (std::size_t i = 0; i < rays; ++i)
      for (std::size_t c = 0; c < 3; ++c) d_difference[3 * i + c] += side * T(row[i]) * T(kGreyOfRgb[c]);
  }
  return loss;
}

}  // namespace likeness
