// A surface that stands for a part of the person, seen by a camera that was never there, in the colours of a
// moment's own picture wherever that shows the place.
#pragma once

#include <vector>

#include "core/train/view_colours.h"

namespace likeness {

struct ProxyPart {
  std::vector<Triangle> triangles;
  std::vector<Vec3f> colours;  // (V) sRGB-encoded, [0, 1]: where the moment's picture does not show the place
  PoseSurface pose;
};

struct ProxyPicture {
  Image8 rgb, alpha;                // (h, w, 3) and (h, w, 1): 255 = the part, 0 = not, or hidden
  Raster raster;                    // of the part alone
  std::vector<std::uint8_t> other;  // (h, w) 1: what may hide the part is seen, before it or beside it
  std::vector<std::uint8_t> inner;  // (h, w) 1: the part's inner side, as of an open neck
};

// moment: whose pose and picture; camera: that sees it. before: what may hide the part, at the moment and in
// the picture; may be null.
ProxyPicture draw_proxy(const ProxyPart& part, const ProxyPart* before, const TrainingView& moment,
                        const Camera& camera);

}  // namespace likeness
