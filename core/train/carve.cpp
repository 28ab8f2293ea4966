// Space carving.
#include "core/train/carve.h"

#include <algorithm>
#include <mutex>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

constexpr std::uint8_t kPersonAlpha = 24;  // of 255: even a tenth of a hair counts

struct Votes {
  int seen = 0, inside = 0;
  void add(bool person) { ++seen, inside += person; }
};

Vec3d displacement_at(const CarveView& view, const Vec3f& p) {
  const GridPlace place = place_in(view.grid, p.x(), p.y());
  Vec3d sum = Vec3d::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t i = 2 * std::size_t(place.node[k]);
    sum += double(place.weight[k]) * Vec3d(view.displacement[i], view.displacement[i + 1], 0);
  }
  return sum;
}

// Square dilation of what counts as person, one axis at a time.
Image8 dilated(const Image8& alpha) {
  const int w = alpha.width, h = alpha.height, radius = std::max(2, w / 64);
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

std::vector<const TrainingView*> views_with_matte(std::span<const TrainingView> views, int count) {
  std::vector<const TrainingView*> with_matte, chosen;
  for (const TrainingView& view : views)
    if (!view.alpha.empty()) with_matte.push_back(&view);
  const std::size_t n = std::min<std::size_t>(with_matte.size(), std::size_t(count));
  for (std::size_t i = 0; i < n; ++i) chosen.push_back(with_matte[i * with_matte.size() / n]);
  return chosen;
}

}  // namespace

std::vector<CarveView> head_carve_views(const TrainingSet& set, int count) {
  const std::vector<const TrainingView*> chosen = views_with_matte(set.views, count);
  std::vector<CarveView> views(chosen.size());
  parallel_for(chosen.size(), [&](std::size_t i) {
    const TrainingView& view = *chosen[i];
    views[i] = {view.camera.intrinsics,
                view.camera.cam_from_world * view.pose.world_from_head,
                {},
                {},
                dilated(to_image(view.alpha)),
                Image8(),
                view.inside};
  });
  return views;
}

std::vector<CarveView> torso_carve_views(const TrainingSet& set, const HeadShape& shape, float bottom,
                                         int count) {
  // -- Necks and busts continue below; what is seen there may be torso.
  const std::vector<Vec3f> neutral = pose_head(set.model, shape, neutral_articulation(set.model));
  std::vector<Triangle> above;
  for (const Triangle& t : set.model.triangles)
    if (std::all_of(t.begin(), t.end(), [&](int v) { return neutral[std::size_t(v)].y() > bottom; }))
      above.push_back(t);

  const std::vector<const TrainingView*> chosen = views_with_matte(own_views(set), count);
  std::vector<CarveView> views(chosen.size());
  parallel_for(chosen.size(), [&](std::size_t i) {
    const TrainingView& view = *chosen[i];
    const Pose cam_from_head = view.camera.cam_from_world * view.pose.world_from_head;
    views[i] = {view.camera.intrinsics,
                view.camera.cam_from_world * view.pose.world_from_torso,
                set.torso_modes.grid,
                set.torso_modes.empty() ? std::vector<float>()
                                        : posed_displacement(set.torso_modes, view.pose.torso_shape),
                dilated(to_image(view.alpha)),
                dilated(silhouette(pose_head(set.model, shape, view.pose.articulation), above,
                                   view.camera.intrinsics, cam_from_head)),
                view.inside};
  });
  return views;
}

void carve(OccupancyGrid& grid, const FieldCube& cube, std::span<const CarveView> views,
           std::span<const std::uint8_t> class_of, std::span<const CarveRule> rules) {
  if (views.empty()) return;
  const int n = grid.resolution;
  LIKENESS_CHECK(class_of.size() == std::size_t(n) * n * n, "%zu classes for %d^3 cells", class_of.size(), n);
  const auto centre = [&](int x, int y, std::size_t z) -> Vec3d {
    return cube.origin.cast<double>() + Vec3d(x + 0.5, y + 0.5, double(z) + 0.5) * double(cube.side) / n;
  };
  // -- A torso's displacement is the same all along z.
  std::vector<std::vector<Vec3d>> moved(views.size());  // (n, n) of each view that deforms: y, x
  parallel_for(views.size(), [&](std::size_t v) {
    if (views[v].grid.empty()) return;
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        moved[v].push_back(displacement_at(views[v], centre(x, y, 0).cast<float>()));
  });
  std::vector<std::uint8_t> keep(class_of.size(), 0);
  parallel_for(std::size_t(n), [&](std::size_t z) {
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const std::size_t cell = (z * n + y) * n + x;
        if (!grid.occupied(x, y, int(z))) continue;
        const CarveRule& rule = rules[class_of[cell]];
        const Vec3d canonical = centre(x, y, z);
        Votes all, beside_head;
        for (std::size_t v = 0; v < views.size(); ++v) {
          const CarveView& view = views[v];
          const Vec3d p = moved[v].empty()
                              ? canonical
                              : canonical + moved[v][std::size_t(y) * std::size_t(n) + std::size_t(x)];
          const Vec3d in_cam = view.cam_from_field * p;
          if (in_cam.z() < 1e-3) continue;
          const Vec2d pixel = project(view.intrinsics, in_cam);
          const int px = int(std::floor(pixel.x())), py = int(std::floor(pixel.y()));
          if (px < 0 || py < 0 || px >= view.person.width || py >= view.person.height) continue;
          if (!view.inside.empty() && !view.inside.contains(px, py)) continue;
          const bool inside = view.person.at(px, py)[0] > 0;
          all.add(inside);
          if (view.head.empty() || view.head.at(px, py)[0] == 0) beside_head.add(inside);
        }
        const Votes& votes = rule.beside_head_only ? beside_head : all;
        keep[cell] = votes.seen > 0 && float(votes.inside) >= rule.needed * float(votes.seen);
      }
  });
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        if (!keep[(std::size_t(z) * n + y) * n + x]) set_occupied(grid, x, y, z, false);
}

}  // namespace likeness
