// Emission-absorption compositing of one ray's samples, front to back, and its derivatives. Plain C++17: the
// CUDA kernels use it too.
//
//   s_i = sigma_i dt_i,  T_1 = 1,  T_{i+1} = T_i exp(-s_i),  w_i = T_i - T_{i+1}
//   C = sum_i w_i c_i + T_{n+1} b
//
// dC/ds_i = T_{i+1} c_i - (what lies behind sample i, background included).
#pragma once

#include <cmath>

#include "core/base/host_device.h"

namespace likeness {

template <class T>
struct Composited {
  T colour[3] = {0, 0, 0};  // without the background
  T transmittance = 1;      // of the whole ray

  // The next sample; depth: s_i.
  LIKENESS_HOST_DEVICE void add(T depth, const T* sample_colour) {
    const T after = transmittance * std::exp(-depth);
    const T weight = transmittance - after;
    for (int c = 0; c < 3; ++c) colour[c] += weight * sample_colour[c];
    transmittance = after;
  }
};

// sigma, dt: (n); colour: (n, 3).
template <class T>
LIKENESS_HOST_DEVICE Composited<T> composite_ray(int n, const T* sigma, const T* dt, const T* colour) {
  Composited<T> out;
  for (int i = 0; i < n; ++i) out.add(sigma[i] * dt[i], colour + 3 * i);
  return out;
}

// Gradients of a loss L through C (d_colour = dL/dC) and through the ray's transmittance, sample by sample
// from the front.
template <class T>
struct CompositeSlopes {
  T behind[3];  // colour of what lies behind the last sample, weighted by the ray's transmittance up to there
  T before = 1;
  T d_colour[3], lost;  // lost: effect of a depth through the transmittance

  LIKENESS_HOST_DEVICE CompositeSlopes(const Composited<T>& forward, const T* background, const T* d_pixel,
                                       T d_transmittance) {
    for (int c = 0; c < 3; ++c) {
      behind[c] = forward.colour[c] + forward.transmittance * background[c];
      d_colour[c] = d_pixel[c];
    }
    lost = -d_transmittance * forward.transmittance;
  }
  // The next sample: returns dL/ds_i and sets d_sample_colour (3).
  LIKENESS_HOST_DEVICE T next(T depth, const T* sample_colour, T* d_sample_colour) {
    const T after = before * std::exp(-depth);
    const T weight = before - after;
    T d_depth = lost;
    for (int c = 0; c < 3; ++c) {
      behind[c] -= weight * sample_colour[c];
      d_depth += d_colour[c] * (after * sample_colour[c] - behind[c]);
      d_sample_colour[c] = weight * d_colour[c];
    }
    before = after;
    return d_depth;
  }
};

// d_sigma: (n); d_sample_colour: (n, 3).
template <class T>
LIKENESS_HOST_DEVICE void composite_ray_backward(int n, const T* sigma, const T* dt, const T* colour,
                                                 const T* background, const Composited<T>& forward,
                                                 const T* d_colour, T d_transmittance, T* d_sigma,
                                                 T* d_sample_colour) {
  CompositeSlopes<T> slopes(forward, background, d_colour, d_transmittance);
  for (int i = 0; i < n; ++i)
    d_sigma[i] = dt[i] * slopes.next(sigma[i] * dt[i], colour + 3 * i, d_sample_colour + 3 * i);
}

}  // namespace likeness
