// Pixel to surface, surface to pixel.
#include "core/holds/carried_colours.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/image/bilinear.h"

namespace likeness {
namespace {

constexpr double kSeenSquarely = 0.35;  // cosine: skin that is seen more edge-on than this is not compared
constexpr double kBehind = 0.005;       // m behind the nearest surface, and a place is hidden

struct Place {
  Vec3f point = Vec3f::Zero(), normal = Vec3f::Zero();
};

Place place_on(const HeadInPicture& head, const Triangle& triangle, const Vec3f& weights) {
  Place place;
  for (int c = 0; c < 3; ++c)
    place.point += weights[c] * head.posed[std::size_t(triangle[c])],
        place.normal += weights[c] * head.normals[std::size_t(triangle[c])];
  return place;
}

}  // namespace

CarriedColours carry_colours(const HeadInPicture& from, const Image& from_rgb, const HeadInPicture& to) {
  LIKENESS_CHECK(from_rgb.channels == 3 && from_rgb.width == from.raster.width &&
                     from_rgb.height == from.raster.height && from.map == to.map,
                 "a picture of %d x %d x %d for a head in %d x %d", from_rgb.width, from_rgb.height,
                 from_rgb.channels, from.raster.width, from.raster.height);
  CarriedColours carried;
  carried.known.assign(to.raster.triangle.size(), 0);
  carried.colour.assign(to.raster.triangle.size(), Vec3f::Zero());
  for (std::size_t i = 0; i < to.raster.triangle.size(); ++i) {
    const int t = to.triangle(i);
    if (t < 0 || !to.map->skin[std::size_t(t)]) continue;
    const Triangle& triangle = to.map->triangles[std::size_t(to.raster.triangle[i])];
    const Vec3f& weights = to.raster.barycentric[i];
    const Place here = place_on(to, triangle, weights), there = place_on(from, triangle, weights);
    if (to.facing(here.point, here.normal) < kSeenSquarely ||
        from.facing(there.point, there.normal) < kSeenSquarely)
      continue;
    const Vec3d in_cam = from.cam_from_head * there.point.cast<double>();
    if (!(in_cam.z() > 0)) continue;
    const Vec2d pixel = project<double>(from.intrinsics, in_cam);
    if (!(pixel.x() >= 1 && pixel.y() >= 1 && pixel.x() < from.raster.width - 1 &&
          pixel.y() < from.raster.height - 1))
      continue;
    const float nearest =
        from.raster.depth[std::size_t(pixel.y()) * std::size_t(from.raster.width) + std::size_t(pixel.x())];
    if (nearest == 0 || in_cam.z() > double(nearest) + kBehind) continue;
    carried.known[i] = 1;
    carried.colour[i] = bilinear_colour(from_rgb, pixel.x(), pixel.y());
  }
  return carried;
}

ColourChange colour_change(const CarriedColours& carried, const HeadInPicture& to, const Image& to_rgb,
                           int least_pixels) {
  std::array<Vec3d, kSkinParts> sums;
  sums.fill(Vec3d::Zero());
  std::array<int, kSkinParts> counts{};
  ColourChange change;
  for (std::size_t i = 0; i < carried.known.size(); ++i) {
    if (!carried.known[i]) continue;
    const Vec3d off =
        (Eigen::Map<const Vec3f>(to_rgb.data.data() + 3 * i) - carried.colour[i]).cast<double>();
    change.mean += off.cwiseAbs().sum() / 3;
    ++change.pixels;
    const auto part = std::size_t(to.map->part[std::size_t(to.triangle(i))]);
    sums[part] += off, ++counts[part];
  }
  if (change.pixels > 0) change.mean /= change.pixels;
  for (std::size_t part = 1; part < sums.size(); ++part)
    if (counts[part] >= std::max(1, least_pixels))
      change.drift = std::max(change.drift, (sums[part] / counts[part]).cwiseAbs().maxCoeff());
  return change;
}

}  // namespace likeness
