// Extents, row by row and all together.
#include "core/camera/mosaic_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace likeness {
MosaicInView::MosaicInView(const Intrinsics& mosaic, const Intrinsics& view, const Mat3d& view_from_mosaic)
    : width_(view.width), height_(view.height), mosaic_width_(mosaic.width) {
  const Mat3d h = pinhole_matrix(view) * view_from_mosaic * inverse_pinhole_matrix(mosaic);
  for (int i = 0; i < 9; ++i) h_[i] = float(h(i / 3, i % 3));
}

std::pair<int, int> MosaicInView::columns(int row) const {
  // The row is a line in the view: clip it by the view's four sides and by the plane of the lens. Each is
  // a u + b >= 0 in the column u, since the conditions are linear once multiplied by the depth.
  const float v = float(row) + 0.5f;
  const float x1 = h_[0], x0 = h_[1] * v + h_[2], y1 = h_[3], y0 = h_[4] * v + h_[5], z1 = h_[6],
              z0 = h_[7] * v + h_[8];
  const float w = float(width_), h = float(height_);
  const float conditions[5][2] = {
      {z1, z0}, {x1, x0}, {y1, y0}, {w * z1 - x1, w * z0 - x0}, {h * z1 - y1, h * z0 - y0}};
  float low = 0, high = float(mosaic_width_);
  for (const auto& [a, b] : conditions) {
    if (a > 0)
      low = std::max(low, -b / a);
    else if (a < 0)
      high = std::min(high, -b / a);
    else if (b < 0)
      return {0, 0};
  }
  if (!(low < high)) return {0, 0};
  return {std::clamp(int(low) - 1, 0, mosaic_width_), std::clamp(int(high) + 2, 0, mosaic_width_)};
}

Intrinsics mosaic_extent(const Intrinsics& reference, std::span<const HandheldView> views, int align) {
  // Around the reference's picture at least, along the border of each view, in px of the reference.
  double left = 0, top = 0, right = reference.width, bottom = reference.height;
  const double reach = std::tan(kMosaicReach);
  const double far_left = reference.cx - reach * reference.fx,
               far_right = reference.cx + reach * reference.fx, far_top = reference.cy - reach * reference.fy,
               far_bottom = reference.cy + reach * reference.fy;
  constexpr int kAlong = 8;  // places on each side of the border
  for (const HandheldView& view : views) {
    const auto map = view_map<double>(reference, reference, view);
    for (int i = 0; i <= kAlong; ++i) {
      const double x = reference.width * double(i) / kAlong, y = reference.height * double(i) / kAlong;
      const double border[4][2] = {
          {x, 0}, {x, double(reference.height)}, {0, y}, {double(reference.width), y}};
      for (const auto& [bx, by] : border) {
        const auto place = view_place(map, bx, by);
        if (place.depth <= 0.1) continue;
        left = std::min(left, place.u), right = std::max(right, place.u);
        top = std::min(top, place.v), bottom = std::max(bottom, place.v);
      }
    }
  }
  left = std::max(left, far_left), right = std::min(right, far_right);
  top = std::max(top, far_top), bottom = std::min(bottom, far_bottom);
  const double x0 = std::floor(left / align) * align, y0 = std::floor(top / align) * align;
  Intrinsics extent = reference;
  extent.cx -= x0, extent.cy -= y0;
  extent.width = int(std::ceil((right - x0) / align)) * align;
  extent.height = int(std::ceil((bottom - y0) / align)) * align;
  return extent;
}

std::vector<std::size_t> covering_views(const Intrinsics& reference, std::span<const HandheldView> views,
                                        std::size_t most) {
  std::set<std::size_t> chosen;
  if (views.size() <= most) {
    for (std::size_t i = 0; i < views.size(); ++i) chosen.insert(i);
    return {chosen.begin(), chosen.end()};
  }
  // Cells of the wall, a dozen across a picture, and how many of the chosen show each.
  const Intrinsics extent = mosaic_extent(reference, views);
  const double cell = reference.width / 12.0;
  const int across = int(extent.width / cell) + 1, down = int(extent.height / cell) + 1;
  std::vector<int> shown(std::size_t(across) * std::size_t(down), 0);
  constexpr int kEnough = 9;  // frames: a median of fewer is noisy
  const auto visit = [&](std::size_t i, const auto& body) {
    const MosaicInView map(extent, reference, views[i]);
    for (int y = 0; y < down; ++y)
      for (int x = 0; x < across; ++x) {
        const auto at = map.place(float((x + 0.5) * cell), float((y + 0.5) * cell));
        if (at.depth > 0 && at.x > 0 && at.y > 0 && at.x < float(reference.width) &&
            at.y < float(reference.height))
          body(shown[std::size_t(y) * std::size_t(across) + std::size_t(x)]);
      }
  };
  const auto choose = [&](std::size_t i) {
    if (chosen.insert(i).second) visit(i, [](int& n) { ++n; });
  };
  for (std::size_t i = 0; i < most; ++i) choose(i * views.size() / most);
  for (std::size_t i = 0; i < views.size() && chosen.size() < 2 * most; ++i) {
    if (chosen.count(i)) continue;
    bool rare = false;
    visit(i, [&](const int& n) { rare |= n < kEnough; });
    if (rare) choose(i);
  }
  return {chosen.begin(), chosen.end()};
}

}  // namespace likeness
