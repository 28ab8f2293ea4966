// Curves from rest to rest, of which the demo's motions are made.
#pragma once

#include <algorithm>

namespace likeness {

// 0 before t = 0, 1 after t = 1, with two continuous derivatives.
inline double ease(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (t * (t * 6 - 15) + 10);
}

// Rises over the first 35 % of [from, to], holds, falls over the last 35 %.
inline double swell(double phase, double from, double to) {
  const double t = (phase - from) / (to - from);
  return ease(t / 0.35) * ease((1 - t) / 0.35);
}

}  // namespace likeness
