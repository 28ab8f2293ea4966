// A surface that stands for a part of the person, seen by a camera that was never there, in the colours of a
// moment's own picture wherever that shows the place.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/train/view_colours.h"

namespace likeness {

struct ProxyPart {
  std::vector<Triangle> triangles;
  std::vector<Vec3f> colours;  // (V) sRGB-encoded, [0, 1]: where the moment's picture does not show the place
  PoseSurface pose;
};

// What the view's camera sees of it, in the view's pose.
Raster see_proxy(const ProxyPart& part, const TrainingView& view);

struct ProxyPicture {
  Image8 rgb, alpha;                // (h, w, 3) and (h, w, 1): 255 = the part, 0 = not, or hidden
  Raster raster;                    // of the part alone
  std::vector<std::uint8_t> other;  // (h, w) 1: what may hide the part is seen, before it or beside it
  std::vector<std::uint8_t> inner;  // (h, w) 1: the part's inner side, as of an open neck
};

// moment: whose picture it is. shown: pose and camera of what is drawn. before: what may hide the part, at
// the moment and in the picture; may be null.
ProxyPicture draw_proxy(const ProxyPart& part, const ProxyPart* before, const TrainingView& moment,
                        const TrainingView& shown);

// One side of a line in a picture.
struct HalfPicture {
  Vec2d from = Vec2d::Zero(), towards = Vec2d::Zero();
  bool at(int x, int y) const { return (Vec2d(x + 0.5, y + 0.5) - from).dot(towards) > 0; }
};
// What lies above a place of a part, by the part's own up.
HalfPicture above_place(const TrainingView& view, const Pose& world_from_part, const Vec3d& place);
HalfPicture other_half(HalfPicture half);

// Share of the person's pixels in the mattes of a few own views, within all of the given halves, that lie
// outside of all the parts: what the parts do not explain. 1 where there is none to explain.
double unexplained(const TrainingSet& set, std::span<const ProxyPart* const> parts,
                   const std::function<std::vector<HalfPicture>(const TrainingView&)>& halves);

}  // namespace likeness
