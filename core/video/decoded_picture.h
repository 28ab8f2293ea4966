// What a reader makes of a decoded frame: upright, in the film's shape, over a backdrop where its alpha hides
// something. Internal to core/video, as frame_to_rgb.h.
#pragma once

#include "core/image/image.h"
#include "core/image/pixel_rect.h"
#include "core/video/frame_to_rgb.h"
#include "core/video/picture_shape.h"

namespace likeness {

struct DecodedPicture {
  Image8 rgb, luma;  // empty: not asked for
  Image8 alpha;      // empty: the picture hides nothing (alpha.h)
};

class DecodedPictures {
 public:
  DecodedPictures() = default;
  // width, height: of the film's picture before it is turned.
  DecodedPictures(const Orientation& orientation, int width, int height, AVRational pixel)
      : orientation_(orientation), width_(width), height_(height), shapes_(width, height, pixel) {}

  // VideoFrame::shape; of every frame, in the order of decoding.
  int shape_of(const AVFrame& decoded) { return shapes_.number(shapes_.place(decoded)); }
  bool changed_shape() const { return shapes_.several(); }
  PixelRect part_of(int shape) const;  // of the upright picture
  // part: of the upright picture; empty: all of it. False: the pixels cannot be converted.
  bool show(const AVFrame& decoded, bool rgb, bool luma, const PixelRect& part, DecodedPicture& result);

 private:
  bool show_masked(const AVFrame& decoded, const PixelRect& place, DecodedPicture& result);
  Image8 upright(Image8 picture, const PixelRect& place) const;

  Orientation orientation_;
  int width_ = 0, height_ = 0;
  PictureShapes shapes_;
  FrameConverter to_rgb_, to_luma_;  // one each: a converter has to be set up again for another format
};

}  // namespace likeness
