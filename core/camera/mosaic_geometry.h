// Where the pixels of a mosaic lie in a view, and what a mosaic must cover.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/camera/handheld_view.h"

namespace likeness {

// Beyond this angle off its axis, on each side, no mosaic shows anything, rad: a flat picture of the wall
// grows with the angle's tangent.
inline constexpr double kMosaicReach = 55 * 3.14159265358979 / 180;

// The homography from a mosaic's pixels to a view's, without distortion.
class MosaicInView {
 public:
  MosaicInView(const Intrinsics& mosaic, const Intrinsics& view, const Mat3d& view_from_mosaic);
  MosaicInView(const Intrinsics& mosaic, const Intrinsics& reference, const HandheldView& view)
      : MosaicInView(mosaic, view_intrinsics(reference, view), view.turn) {}

  struct Place {
    float x, y, depth;  // nothing is seen where depth is not above 0
  };
  Place place(float u, float v) const {
    const float x = h_[0] * u + h_[1] * v + h_[2], y = h_[3] * u + h_[4] * v + h_[5],
                z = h_[6] * u + h_[7] * v + h_[8];
    return {x / z, y / z, z};
  }
  // Columns [first, second) of a mosaic row outside of which the view shows nothing.
  std::pair<int, int> columns(int row) const;

 private:
  float h_[9];
  int width_, height_, mosaic_width_;
};

// What a mosaic of these views must cover, at the reference's focal lengths: the union of what they show, cut
// at kMosaicReach. Its principal point lies a multiple of `align` px off the reference's, so that the
// pyramids of two extents agree.
Intrinsics mosaic_extent(const Intrinsics& reference, std::span<const HandheldView> views, int align = 16);

// At most `most` of the views, ascending, evenly spread over time, and besides as many more as show what
// hardly one of these does.
std::vector<std::size_t> covering_views(const Intrinsics& reference, std::span<const HandheldView> views,
                                        std::size_t most);

}  // namespace likeness
