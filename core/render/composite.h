// Emission-absorption compositing of one ray's samples, front to back, and its derivatives.
//
//   s_i = sigma_i dt_i,  T_1 = 1,  T_{i+1} = T_i exp(-s_i),  w_i = T_i - T_{i+1}
//   C = sum_i w_i c_i + T_{n+1} b
//
// dC/ds_i = T_{i+1} c_i - (what lies behind sample i, background included).
#pragma once

#include <cmath>

namespace likeness {

template <class T>
struct Composited {
  T colour[3] = {0, 0, 0};  // without the background
  T transmittance = 1;      // of the whole ray
};

// sigma, dt: (n); colour: (n, 3).
template <class T>
Composited<T> composite_ray(int n, const T* sigma, const T* dt, const T* colour) {
  Composited<T> out;
  for (int i = 0; i < n; ++i) {
    const T after = out.transmittance * std::exp(-sigma[i] * dt[i]);
    const T weight = out.transmittance - after;
    for (int c = 0; c < 3; ++c) out.colour[c] += weight * colour[3 * i + c];
    out.transmittance = after;
  }
  return out;
}

// Gradients of a loss L through C (d_colour = dL/dC) and, beside it, through the ray's transmittance.
// d_sigma: (n); d_sample_colour: (n, 3).
template <class T>
void composite_ray_backward(int n, const T* sigma, const T* dt, const T* colour, const T* background,
                            const Composited<T>& forward, const T* d_colour, T d_transmittance, T* d_sigma,
                            T* d_sample_colour) {
  T behind[3];  // colour of what lies behind sample i, weighted by the ray's transmittance up to there
  for (int c = 0; c < 3; ++c) behind[c] = forward.colour[c] + forward.transmittance * background[c];
  T before = 1;
  for (int i = 0; i < n; ++i) {
    const T after = before * std::exp(-sigma[i] * dt[i]);
    const T weight = before - after;
    T d_depth = -d_transmittance * forward.transmittance;
    for (int c = 0; c < 3; ++c) {
      behind[c] -= weight * colour[3 * i + c];
      d_depth += d_colour[c] * (after * colour[3 * i + c] - behind[c]);
      d_sample_colour[3 * i + c] = weight * d_colour[c];
    }
    d_sigma[i] = dt[i] * d_depth;
    before = after;
  }
}

}  // namespace likeness
