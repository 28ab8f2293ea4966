// Small arithmetic of the field for processor and device. Plain C++17. Symbols as in field.h.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/field/device_kernels.h"

namespace likeness {

// *at += value, atomic on a device.
LIKENESS_HOST_DEVICE inline void add_to(float* at, float value) {
#ifdef __CUDA_ARCH__
  atomicAdd(at, value);
#else
  *at += value;
#endif
}

// The same for entries of a grid, which lie at multiples of their size.
template <int kCount>
LIKENESS_HOST_DEVICE inline void add_entry(float* at, const float (&value)[kCount]) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 900 && __CUDACC_VER_MAJOR__ >= 13
  if (kCount == 2) {
    atomicAdd(reinterpret_cast<float2*>(at), make_float2(value[0], value[kCount - 1]));
    return;
  }
  if (kCount % 4 == 0) {
    for (int k = 0; k + 3 < kCount; k += 4)
      atomicAdd(reinterpret_cast<float4*>(at + k),
                make_float4(value[k], value[k + 1], value[k + 2], value[k + 3]));
    return;
  }
#endif
  for (int k = 0; k < kCount; ++k) add_to(at + k, value[k]);
}

LIKENESS_HOST_DEVICE inline bool is_finite(double value) {
  return value - value == 0;  // neither infinite nor not a number
}

// Density of the raw output, and its derivative from the density itself.
LIKENESS_HOST_DEVICE inline float density_of(float raw) {
  const float bounded = expf(raw < kDensityKnee ? raw : kDensityKnee);
  return raw > kDensityKnee ? bounded * (1 + raw - kDensityKnee) : bounded;
}
LIKENESS_HOST_DEVICE inline float density_slope(float sigma) {
  const float knee = 8103.0839276f;  // e^kDensityKnee
  return sigma < knee ? sigma : knee;
}

LIKENESS_HOST_DEVICE inline float network_output(NetworkOutput kind, int index, float raw) {
  if (kind == NetworkOutput::slice) return 0.5f * tanhf(raw) + 0.5f;
  if (kind == NetworkOutput::colour) return 1 / (1 + expf(-raw));
  return index == 0 ? density_of(raw) : raw;
}

// Derivative of the output with respect to the raw output, from the output.
LIKENESS_HOST_DEVICE inline float network_output_slope(NetworkOutput kind, int index, float out) {
  if (kind == NetworkOutput::slice) return 2 * out * (1 - out);  // (1 - w^2) / 2, w = 2 out - 1
  if (kind == NetworkOutput::colour) return out * (1 - out);
  return index == 0 ? density_slope(out) : 1.0f;
}

// Harmonic `index` of kDirectionFeatures of a unit direction.
LIKENESS_HOST_DEVICE inline float direction_harmonic(int index, float x, float y, float z) {
  switch (index) {
    case 0:
      return float(kHarmonic0);
    case 1:
      return float(kHarmonic1) * y;
    case 2:
      return float(kHarmonic1) * z;
    case 3:
      return float(kHarmonic1) * x;
    case 4:
      return float(kHarmonic2) * x * y;
    case 5:
      return float(kHarmonic2) * y * z;
    case 6:
      return float(kHarmonic2z) * (3 * z * z - 1);
    case 7:
      return float(kHarmonic2) * x * z;
    default:
      return float(kHarmonic2xy) * (x * x - y * y);
  }
}

// One value under Adam; `rate` is corrected for both moments' bias.
LIKENESS_HOST_DEVICE inline void adam_value(float& value, float gradient, float& first, float& second,
                                            const AdamMoments& m, float rate) {
  first = m.beta1 * first + (1 - m.beta1) * gradient;
  second = m.beta2 * second + (1 - m.beta2) * gradient * gradient;
  value -= rate * first / (sqrtf(second) + m.epsilon);
}

// Counts a step of a line of the tables; returns its rate.
LIKENESS_HOST_DEVICE inline float line_rate(const AdamLinesArgs& a, std::uint32_t step) {
  return a.numbers->table_rate * a.corrections[step < a.correction_count ? step : a.correction_count - 1];
}

LIKENESS_HOST_DEVICE inline void adam_table_value(const AdamLinesArgs& a, float& value, float gradient,
                                                  float& first, float& second, float rate) {
  value *= a.numbers->table_keep;
  adam_value(value, gradient, first, second, a.moments, rate);
}

// A line of the tables: its gradient is consumed and, unless the step is void, its values are updated.
LIKENESS_HOST_DEVICE inline void adam_line(const AdamLinesArgs& a, std::size_t line) {
  const std::size_t begin = line * kTableLine, end = begin + kTableLine;
  bool any = false;
  for (std::size_t i = begin; i < end; ++i) any = any || a.gradients[i] != 0;
  if (!any) return;
  if (is_finite(a.sums->error)) {
    const float rate = line_rate(a, ++a.line_steps[line]);
    for (std::size_t i = begin; i < end; ++i)
      adam_table_value(a, a.parameters[i], a.gradients[i], a.first[i], a.second[i], rate);
  }
  for (std::size_t i = begin; i < end; ++i) a.gradients[i] = 0;
}

LIKENESS_HOST_DEVICE inline void adam_network(const AdamNetworksArgs& a, std::size_t item) {
  const std::size_t i = a.begin + item;
  if (is_finite(a.sums->error) && a.numbers->count[a.field] > 0)
    adam_value(a.parameters[i], a.gradients[i], a.first[i], a.second[i], a.moments,
               a.numbers->network_rate[a.field]);
  a.gradients[i] = 0;
}

// By the threads of one block.
template <class Block>
LIKENESS_HOST_DEVICE void adam_codes(Block& block, const AdamCodesArgs& a) {
  const int half = int(a.views * a.length);
  const bool moves = is_finite(a.sums->error) && a.numbers->count[0] > 0;
  block.for_each(half, [&](int i) {
    const float slope = a.gradients[i] + 2 * a.penalty * a.codes[i] / float(half);
    if (moves) adam_value(a.codes[i], slope, a.first[i], a.second[i], a.moments, a.numbers->code_rate);
  });
  block.for_each(2 * half, [&](int i) { a.gradients[i] = 0; });
  if (!moves) return;
  block.for_each(int(a.length), [&](int l) {
    double mean = 0;
    for (std::uint32_t v = 0; v < a.centred; ++v) mean += double(a.codes[v * a.length + l]);
    mean /= double(a.centred);
    for (std::uint32_t v = 0; v < a.centred; ++v) a.codes[v * a.length + l] -= float(mean);
  });
}

}  // namespace likeness
