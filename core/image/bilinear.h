// The value of a picture between its pixels, whose centres lie at half-integers.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/base/linalg.h"
#include "core/image/image.h"

namespace likeness {

// Whether the place lies between four pixel centres.
template <class T>
bool inside_bilinear(const BasicImage<T>& picture, double x, double y) {
  return x >= 0.5 && y >= 0.5 && x < picture.width - 0.5 && y < picture.height - 0.5;
}

// Of a one-channel picture. Places outside extrapolate from the pixels at the border. slope: the exact
// derivative (d/dx, d/dy), or null. The picture is at least 2 x 2.
template <class T>
double bilinear(const BasicImage<T>& picture, double x, double y, double* slope = nullptr) {
  x -= 0.5, y -= 0.5;
  const int ix = std::clamp(static_cast<int>(x), 0, picture.width - 2),
            iy = std::clamp(static_cast<int>(y), 0, picture.height - 2);
  const double fx = x - ix, fy = y - iy;
  const T* p = picture.data.data() + static_cast<std::size_t>(iy) * picture.width + ix;
  const double a = p[0], b = p[1], c = p[picture.width], d = p[picture.width + 1];
  if (slope) slope[0] = (1 - fy) * (b - a) + fy * (d - c), slope[1] = (1 - fx) * (c - a) + fx * (d - b);
  return (1 - fy) * ((1 - fx) * a + fx * b) + fy * ((1 - fx) * c + fx * d);
}

// Of a picture with three channels, in its own values; places outside have the colour at its border. The
// picture is at least 2 x 2.
template <class T>
Vec3f bilinear_colour(const BasicImage<T>& picture, double x, double y) {
  x = std::clamp(x - 0.5, 0.0, picture.width - 1.0), y = std::clamp(y - 0.5, 0.0, picture.height - 1.0);
  const int ix = std::min(static_cast<int>(x), picture.width - 2),
            iy = std::min(static_cast<int>(y), picture.height - 2);
  const float fx = float(x - ix), fy = float(y - iy);
  Vec3f colour;
  for (int c = 0; c < 3; ++c)
    colour[c] =
        (1 - fy) * ((1 - fx) * float(picture.at(ix, iy)[c]) + fx * float(picture.at(ix + 1, iy)[c])) +
        fy * ((1 - fx) * float(picture.at(ix, iy + 1)[c]) + fx * float(picture.at(ix + 1, iy + 1)[c]));
  return colour;
}

}  // namespace likeness
