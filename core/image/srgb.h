// The sRGB curve (IEC 61966-2-1): what pictures store against the light that it stands for, both 0..1.
#pragma once

#include <cmath>

namespace likeness {

template <class T>
T linear_of_srgb(T stored) {
  return stored <= T(0.04045) ? stored / T(12.92) : std::pow((stored + T(0.055)) / T(1.055), T(2.4));
}

template <class T>
T srgb_of_linear(T light) {
  return light <= T(0.0031308) ? T(12.92) * light : T(1.055) * std::pow(light, T(1) / T(2.4)) - T(0.055);
}

}  // namespace likeness
