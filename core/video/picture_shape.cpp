// Fitting pictures into the film's: see picture_shape.h.
#include "core/video/picture_shape.h"

extern "C" {
#include <libavutil/frame.h>
}

#include <algorithm>
#include <cmath>

namespace likeness {

PixelRect PictureShapes::place(const AVFrame& frame) {
  const AVRational own = frame.sample_aspect_ratio;
  if (first_.den == 0) first_ = {own.num, std::max(1, own.den)};
  const bool as_at_first = own.num <= 0 || first_.num <= 0 || av_cmp_q(own, first_) == 0;
  const AVRational pixel = !as_at_first || pixel_.num <= 0 ? own : pixel_;
  const double wide = pixel.num > 0 && pixel.den > 0 ? frame.width * av_q2d(pixel) : frame.width;
  const double scale = std::min(width_ / wide, double(height_) / frame.height);
  const double width = std::round(wide * scale), height = std::round(frame.height * scale);
  // Coded sizes are rounded to even numbers, and codecs to blocks.
  constexpr double kSame = 0.01;
  if (width > (1 - kSame) * width_ - 1 && height > (1 - kSame) * height_ - 1) return {0, 0, width_, height_};
  const int w = std::max(1, int(width)), h = std::max(1, int(height));
  return {(width_ - w) / 2, (height_ - h) / 2, w, h};
}

int PictureShapes::number(const PixelRect& place) {
  const auto known = std::ranges::find(places_, place);
  if (known != places_.end()) return int(known - places_.begin());
  places_.push_back(place);
  return int(places_.size()) - 1;
}

Image8 put_in_place(Image8 picture, const PixelRect& place, int width, int height) {
  if (picture.empty() || (place.width == width && place.height == height)) return picture;
  Image8 whole = crop(picture, -place.x, -place.y, width, height);
  fill_outside(whole, place, 0);
  return whole;
}

}  // namespace likeness
