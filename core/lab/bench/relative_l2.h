// How far numbers lie from the truth.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>

namespace likeness {

// |value - truth| / |truth|; the plain norm where the truth is zero.
inline double relative_l2(std::span<const float> value, std::span<const double> truth) {
  double error = 0, size = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    error += (double(value[i]) - truth[i]) * (double(value[i]) - truth[i]);
    size += truth[i] * truth[i];
  }
  return size > 0 ? std::sqrt(error / size) : std::sqrt(error);
}

}  // namespace likeness
