#include "core/track/torso/convex_outline.h"

#include <algorithm>

namespace likeness {

ConvexOutline convex_outline(std::vector<Vec2d> points) {
  // -- Hull: lower then upper chain.
  std::sort(points.begin(), points.end(),
            [](const Vec2d& a, const Vec2d& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  ConvexOutline outline;
  std::vector<Vec2d>& hull = outline.corners;
  for (int chain = 0; chain < 2; ++chain) {
    const std::size_t first = hull.size();
    for (const Vec2d& p : points) {
      while (hull.size() >= first + 2) {
        const Vec2d a = hull.back() - hull[hull.size() - 2], b = p - hull.back();
        if (a.x() * b.y() - a.y() * b.x() > 0) break;
        hull.pop_back();
      }
      hull.push_back(p);
    }
    if (!hull.empty()) hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  // -- The chains go round with the inside on their left.
  for (std::size_t i = 0; i < hull.size() && hull.size() >= 3; ++i) {
    const Vec2d along = (hull[(i + 1) % hull.size()] - hull[i]).normalized();
    outline.normals.push_back({along.y(), -along.x()});
    outline.offsets.push_back(outline.normals.back().dot(hull[i]));
    outline.box.extend(hull[i]);
  }
  return outline;
}

bool holds(const ConvexOutline& outline, const Vec2d& place, double margin) {
  // Moved sides meet beyond the moved box, but not by far.
  const Eigen::AlignedBox2d& box = outline.box;
  const double reach = 4 * std::max(0.0, margin);
  if ((place.array() < box.min().array() - reach).any() || (place.array() > box.max().array() + reach).any())
    return false;
  for (std::size_t i = 0; i < outline.normals.size(); ++i)
    if (outline.normals[i].dot(place) > outline.offsets[i] + margin) return false;
  return !outline.normals.empty();
}

}  // namespace likeness
