// The picture types. Row-major, origin top left, channels interleaved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/image/pixel_rect.h"

namespace likeness {

template <class T>
struct BasicImage {
  int width = 0, height = 0, channels = 0;
  std::vector<T> data;  // (height, width, channels)

  BasicImage() = default;
  BasicImage(int w, int h, int c, T fill = T(0))
      : width(w), height(h), channels(c), data(std::size_t(w) * h * c, fill) {}
  bool empty() const { return data.empty(); }
  std::size_t pixels() const { return std::size_t(width) * height; }
  T* at(int x, int y) { return data.data() + (std::size_t(y) * width + x) * channels; }
  const T* at(int x, int y) const { return data.data() + (std::size_t(y) * width + x) * channels; }
};

using Image = BasicImage<float>;  // sRGB-encoded (display-referred) in [0, 1]; RGB, RGBA or one channel
using Image8 = BasicImage<std::uint8_t>;  // the same in 0..255

Image to_float(const Image8& image);
Image8 to_bytes(const Image& image);  // rounds and clamps

// The part of `image` inside the rectangle [x, x+width) x [y, y+height); outside the picture the border is
// repeated.
Image8 crop(const Image8& image, int x, int y, int width, int height);
// The same part; an empty one: the whole picture.
Image8 crop(const Image8& image, const PixelRect& part);
// Sets what lies beyond `inside` to one level in all channels; an empty one: nothing lies beyond it.
void fill_outside(Image8& image, const PixelRect& inside, std::uint8_t level);
// Area filtering when shrinking, bilinear when enlarging; done on the encoded values.
Image8 resize(const Image8& image, int width, int height);
// A larger picture by Catmull-Rom splines, which pass through the given pixels and keep edges sharp; kept
// between the minimum and maximum of the four neighbours, so that there is no ringing.
Image enlarge(const Image& image, int width, int height);

}  // namespace likeness
