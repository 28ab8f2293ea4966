// Order statistics of a list of values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace likeness {

// The value that `share` of the others lie below, at the nearest rank; 0 for no values. share: 0..1.
template <class T>
T quantile(std::vector<T> values, double share) {
  if (values.empty()) return T{};
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// For an even number, the upper of the two middle values.
template <class T>
T median(std::vector<T> values) {
  return quantile(std::move(values), 0.5);
}

}  // namespace likeness
