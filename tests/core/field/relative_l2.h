// How far arrays of numbers are from the truth.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

namespace likeness {

// |value - truth| / |truth|, or |value| where the truth is zero.
template <class A, class B>
double relative_l2(const A& value, const B& truth) {
  double error = 0, size = 0;
  EXPECT_EQ(value.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double apart = double(value[i]) - double(truth[i]);
    error += apart * apart;
    size += double(truth[i]) * double(truth[i]);
  }
  return size > 0 ? std::sqrt(error / size) : std::sqrt(error);
}

}  // namespace likeness
