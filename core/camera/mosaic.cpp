// Homographies between cameras at one place: see mosaic.h.
#include "core/camera/mosaic.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/mean_rotation.h"
#include "core/base/parallel.h"

namespace likeness {
Mat3d pixels_between(const Camera& from, const Camera& to) {
  return pinhole_matrix(to.intrinsics) * to.cam_from_world.linear() *
         from.cam_from_world.linear().transpose() * inverse_pinhole_matrix(from.intrinsics);
}

Image8 mosaic_seen_by(const Mosaic& mosaic, const Camera& to, Image8* known) {
  const int width = to.intrinsics.width, height = to.intrinsics.height;
  const Mat3d map = pixels_between(to, mosaic.camera);
  Image8 seen(width, height, 3);
  if (known) *known = Image8(width, height, 1, 0);
  const int right = mosaic.colour.width - 1, bottom = mosaic.colour.height - 1;
  const auto is_known = [&](int x, int y) { return mosaic.known.empty() || mosaic.known.at(x, y)[0] == 255; };
  parallel_for(std::size_t(height), [&](std::size_t row) {
    const int y = int(row);
    for (int x = 0; x < width; ++x) {
      const Vec3d at = map * Vec3d(x + 0.5, y + 0.5, 1);
      if (at.z() <= 0) continue;
      const double u = at.x() / at.z() - 0.5, v = at.y() / at.z() - 0.5;
      const double cu = std::clamp(u, 0.0, double(right)), cv = std::clamp(v, 0.0, double(bottom));
      const int x0 = int(cu), y0 = int(cv), x1 = std::min(x0 + 1, right), y1 = std::min(y0 + 1, bottom);
      const double a = cu - x0, b = cv - y0;
      for (int c = 0; c < 3; ++c)
        seen.at(x, y)[c] = std::uint8_t(
            std::lround((1 - b) * ((1 - a) * mosaic.colour.at(x0, y0)[c] + a * mosaic.colour.at(x1, y0)[c]) +
                        b * ((1 - a) * mosaic.colour.at(x0, y1)[c] + a * mosaic.colour.at(x1, y1)[c])));
      const bool inside = u > -0.5 && v > -0.5 && u < right + 0.5 && v < bottom + 0.5;
      if (known && inside && is_known(x0, y0) && is_known(x1, y0) && is_known(x0, y1) && is_known(x1, y1))
        known->at(x, y)[0] = 255;
    }
  });
  return seen;
}

Camera mosaic_camera(const std::vector<Camera>& cameras, double reach, std::size_t most_pixels) {
  LIKENESS_CHECK(!cameras.empty(), "a mosaic of %zu cameras", cameras.size());
  std::vector<Mat3d> turns;
  double focal = 0;
  for (const Camera& camera : cameras) {
    turns.push_back(camera.cam_from_world.linear());
    focal += camera.intrinsics.fx / double(cameras.size());
  }
  Camera middle;
  middle.frame = -1;
  middle.cam_from_world.linear() = mean_rotation(turns);
  middle.intrinsics.fx = middle.intrinsics.fy = focal;
  double left = 0, right = 0, top = 0, bottom = 0;  // px from the axis
  const double farthest = focal * std::tan(reach);
  for (const Camera& camera : cameras) {
    const Mat3d map = pixels_between(camera, middle);
    const double width = camera.intrinsics.width, height = camera.intrinsics.height;
    for (const Vec2d& corner : {Vec2d(0, 0), Vec2d(width, 0), Vec2d(0, height), Vec2d(width, height)}) {
      const Vec3d at = map * Vec3d(corner.x(), corner.y(), 1);
      // Behind the middle's camera: as far as it may go.
      const Vec2d place = at.z() > 1e-6
                              ? Vec2d(at.x() / at.z(), at.y() / at.z())
                              : Vec2d(at.x() < 0 ? -farthest : farthest, at.y() < 0 ? -farthest : farthest);
      left = std::min(left, place.x()), right = std::max(right, place.x());
      top = std::min(top, place.y()), bottom = std::max(bottom, place.y());
    }
  }
  left = std::max(left, -farthest), right = std::min(right, farthest);
  top = std::max(top, -farthest), bottom = std::min(bottom, farthest);
  Intrinsics& k = middle.intrinsics;
  const double scale = std::min(1.0, std::sqrt(double(most_pixels) / ((right - left) * (bottom - top))));
  k.fx *= scale, k.fy *= scale;
  k.cx = -left * scale, k.cy = -top * scale;
  k.width = std::max(1, int(std::ceil((right - left) * scale)));
  k.height = std::max(1, int(std::ceil((bottom - top) * scale)));
  return middle;
}

}  // namespace likeness
