// Films whose picture changes its shape in the middle, as calls and turned phones write them: what the header
// says holds for the beginning only. Internal to core/video, as frame_to_rgb.h.
#pragma once

#include <vector>

#include "core/image/image.h"
#include "core/image/pixel_rect.h"

extern "C" {
#include <libavutil/rational.h>
}

struct AVFrame;

namespace likeness {

// Where decoded pictures go within the film's, as they are coded, before any turning.
class PictureShapes {
 public:
  PictureShapes() = default;
  // The film's picture, in square pixels, and the shape of a coded pixel by the container; 0: not said.
  PictureShapes(int width, int height, AVRational pixel) : width_(width), height_(height), pixel_(pixel) {}

  // As large as it fits, in the middle; the whole picture where the shape is the header's, whatever the size.
  // Frames come in the order of decoding.
  PixelRect place(const AVFrame& frame);
  // Of such a place: which of the film's shapes it is, in the order in which they first came, from 0 on.
  int number(const PixelRect& place);
  const PixelRect& place_of(int number) const { return places_[std::size_t(number)]; }
  bool several() const { return places_.size() > 1; }

 private:
  int width_ = 0, height_ = 0;
  AVRational pixel_{0, 1};  // of the container, which overrules the first frame's
  AVRational first_{0, 0};  // of the first frame; a denominator of 0: none was seen
  std::vector<PixelRect> places_;
};

// A picture in its place within one of width x height, black around it.
Image8 put_in_place(Image8 picture, const PixelRect& place, int width, int height);

}  // namespace likeness
