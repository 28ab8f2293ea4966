// Masked reduction, and the noise of a picture.
#include "core/camera/grey_pyramid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/base/quantile.h"

namespace likeness {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
constexpr float kEnoughKnown = 0.75f;

// Weighted values and weights of a row, halved.
void halve_row(const float* row, int width, int half, std::vector<float>& padded, float* value,
               float* weight) {
  // Two planes with two pixels of margin: what is not known weighs nothing.
  const std::size_t size = 2 * std::size_t(half) + 4;
  padded.assign(2 * size, 0);
  float *v = padded.data() + 1, *w = padded.data() + size + 1;
  for (int x = 0; x < width; ++x) {
    const bool known = row[x] == row[x];
    v[x] = known ? row[x] : 0;
    w[x] = known ? 1.0f : 0.0f;
  }
  for (int x = 0; x < half; ++x) {
    value[x] = v[2 * x - 1] + 3 * (v[2 * x] + v[2 * x + 1]) + v[2 * x + 2];
    weight[x] = w[2 * x - 1] + 3 * (w[2 * x] + w[2 * x + 1]) + w[2 * x + 2];
  }
}

}  // namespace

GreyPicture grey_picture(const Image8& grey, const Image8* hole, int rim) {
  LIKENESS_CHECK(grey.channels == 1 &&
                     (!hole || hole->empty() || (hole->width == grey.width && hole->height == grey.height)),
                 "a grey picture of %d x %d with %d channels", grey.width, grey.height, grey.channels);
  GreyPicture picture(grey.width, grey.height, 1, kNothing);
  const bool whole = !hole || hole->empty();
  for (int y = rim; y < grey.height - rim; ++y)
    for (int x = rim; x < grey.width - rim; ++x)
      if (whole || !*hole->at(x, y)) *picture.at(x, y) = *grey.at(x, y);
  return picture;
}

GreyPicture halved(const GreyPicture& picture) {
  const int width = (picture.width + 1) / 2, height = (picture.height + 1) / 2;
  GreyPicture half(width, height, 1);
  // Halved rows 2y-1 .. 2y+2; each is made once.
  const std::size_t w = std::size_t(width);
  std::vector<float> rows(4 * 2 * w, 0), padded;
  const auto value_of = [&](int y) { return rows.data() + std::size_t((y + 4) % 4) * 2 * w; };
  const auto make = [&](int y) {
    float* value = value_of(y);
    if (y < 0 || y >= picture.height)
      std::fill(value, value + 2 * w, 0.0f);
    else
      halve_row(picture.at(0, y), picture.width, width, padded, value, value + w);
  };
  make(-1), make(0);
  for (int y = 0; y < height; ++y) {
    make(2 * y + 1), make(2 * y + 2);
    const float *a = value_of(2 * y - 1), *b = value_of(2 * y), *c = value_of(2 * y + 1),
                *d = value_of(2 * y + 2);
    float* out = half.at(0, y);
    for (std::size_t x = 0; x < w; ++x) {
      const float value = a[x] + 3 * (b[x] + c[x]) + d[x],
                  weight = a[x + w] + 3 * (b[x + w] + c[x + w]) + d[x + w];
      out[x] = weight >= 64 * kEnoughKnown ? value / weight : kNothing;
    }
  }
  return half;
}

std::vector<GreyPicture> grey_pyramid(GreyPicture picture, int levels) {
  std::vector<GreyPicture> pyramid;
  pyramid.push_back(std::move(picture));
  while (int(pyramid.size()) < levels) pyramid.push_back(halved(pyramid.back()));
  return pyramid;
}

int pyramid_levels(int width, int height) {
  int levels = 1;
  for (int side = std::min(width, height); side >= 2 * 28; side /= 2) ++levels;
  return levels;
}

Intrinsics at_level(Intrinsics k, int level) {
  const double scale = std::ldexp(1.0, -level);
  k.fx *= scale, k.fy *= scale, k.cx *= scale, k.cy *= scale;
  for (int i = 0; i < level; ++i) k.width = (k.width + 1) / 2, k.height = (k.height + 1) / 2;
  return k;
}

double pixel_noise(const GreyPicture& picture) {
  std::vector<float> strengths;
  for (int y = 1; y + 1 < picture.height; y += 2)
    for (int x = 1; x + 1 < picture.width; x += 2) {
      const float *a = picture.at(x, y - 1), *b = picture.at(x, y), *c = picture.at(x, y + 1);
      const float strength = a[-1] + a[1] + c[-1] + c[1] - 2 * (a[0] + b[-1] + b[1] + c[0]) + 4 * b[0];
      if (strength == strength) strengths.push_back(std::abs(strength));
    }
  // Of white noise the operator makes noise of six times its deviation.
  return 1.4826 / 6 * median(std::move(strengths));
}

}  // namespace likeness
