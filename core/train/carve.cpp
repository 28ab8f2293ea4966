// Space carving.
#include "core/train/carve.h"

#include <algorithm>
#include <mutex>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace likeness {
namespace {

constexpr std::uint8_t kPersonAlpha = 24;  // of 255: even a tenth of a hair counts

// Square dilation, one axis at a time.
Image8 dilated_person(const Image8& alpha, int radius) {
  const int w = alpha.width, h = alpha.height;
  Image8 rows(w, h, 1), out(w, h, 1);
  for (int y = 0; y < h; ++y) {
    int last = -radius - 1;
    for (int x = 0; x < w + radius; ++x) {
      if (x < w && alpha.at(x, y)[0] >= kPersonAlpha) last = x;
      if (x - radius >= 0 && x - radius < w && last >= x - 2 * radius) rows.at(x - radius, y)[0] = 255;
    }
  }
  for (int x = 0; x < w; ++x) {
    int last = -radius - 1;
    for (int y = 0; y < h + radius; ++y) {
      if (y < h && rows.at(x, y)[0]) last = y;
      if (y - radius >= 0 && y - radius < h && last >= y - 2 * radius) out.at(x, y - radius)[0] = 255;
    }
  }
  return out;
}

}  // namespace

std::vector<CarveView> carve_views(const TrainingSet& set, bool torso, int count) {
  std::vector<const TrainingView*> with_matte;
  for (const TrainingView& view : set.views)
    if (!view.alpha.empty()) with_matte.push_back(&view);
  const std::size_t n = std::min<std::size_t>(with_matte.size(), std::size_t(count));
  std::vector<CarveView> views(n);
  parallel_for(n, [&](std::size_t i) {
    const TrainingView& view = *with_matte[i * with_matte.size() / n];
    const int radius = std::max(2, view.alpha.width / 64);
    views[i] = {view.camera.intrinsics,
                view.camera.cam_from_world * (torso ? view.world_from_torso : view.world_from_head),
                dilated_person(view.alpha, radius)};
  });
  return views;
}

void carve(OccupancyGrid& grid, const FieldCube& cube, std::span<const CarveView> views,
           std::span<const std::uint8_t> class_of, std::span<const float> needed) {
  if (views.empty()) return;
  const int n = grid.resolution;
  LIKENESS_CHECK(class_of.size() == std::size_t(n) * n * n, "%zu classes for %d^3 cells", class_of.size(), n);
  std::vector<std::uint8_t> keep(class_of.size(), 0);
  parallel_for(std::size_t(n), [&](std::size_t z) {
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const std::size_t cell = (z * n + y) * n + x;
        if (!grid.occupied(x, y, int(z))) continue;
        const Vec3d p =
            cube.origin.cast<double>() + Vec3d(x + 0.5, y + 0.5, double(z) + 0.5) * double(cube.side) / n;
        int seen = 0, inside = 0;
        for (const CarveView& view : views) {
          const Vec3d in_cam = view.cam_from_field * p;
          if (in_cam.z() < 1e-3) continue;
          const Vec2d pixel = project(view.intrinsics, in_cam);
          const int px = int(std::floor(pixel.x())), py = int(std::floor(pixel.y()));
          if (px < 0 || py < 0 || px >= view.person.width || py >= view.person.height) continue;
          ++seen;
          inside += view.person.at(px, py)[0] > 0;
        }
        keep[cell] = seen > 0 && float(inside) >= needed[class_of[cell]] * float(seen);
      }
  });
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        if (!keep[(std::size_t(z) * n + y) * n + x]) set_occupied(grid, x, y, z, false);
}

}  // namespace likeness
