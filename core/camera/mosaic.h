// The wall behind a hand-held camera as one picture, wider than any frame: a camera that only turns and zooms
// sees parts of it. Pinholes without distortion, all at one place; their translations are not looked at.
#pragma once

#include "core/camera/camera.h"
#include "core/image/image.h"

namespace likeness {

struct Mosaic {
  Image8 colour;  // (h, w, 3) sRGB; empty: there is none
  Image8 known;   // (h, w, 1) 255 = it was seen there; less = a guess; empty: seen everywhere
  Camera camera;  // that would take it

  bool empty() const { return colour.empty(); }
};

// (3, 3) takes pixels of one camera, homogeneous, to those of the other: K_to R_to R_from^T K_from^-1, so
// that the third coordinate is positive in front of both. Of corners as in camera.h: pixel centres at one
// half.
Mat3d pixels_between(const Camera& from, const Camera& to);

// What `to` sees of the mosaic, bilinear; its edge is continued where the mosaic ends. known: where all four
// pixels read are (255), else 0; null: not asked for.
Image8 mosaic_seen_by(const Mosaic& mosaic, const Camera& to, Image8* known = nullptr);

// The smallest picture, along the mean of the cameras' directions and with their mean focal length, that
// holds what all of them see; no farther than `reach` rad from its middle and at most `most_pixels`, for
// which it is coarser. cameras: at least one, all of one size.
Camera mosaic_camera(const std::vector<Camera>& cameras, double reach, std::size_t most_pixels);

}  // namespace likeness
