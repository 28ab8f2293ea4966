// Vertices against the z-buffer of their own surface.
#include "core/train/view_colours.h"

#include <algorithm>

#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr double kHiddenBehind = 0.006;  // m that a place may lie behind what is seen there
constexpr double kSlantest = 0.15;       // cosine of normal and view
constexpr int kInside = 250;             // of the matte

}  // namespace

std::vector<std::size_t> evenly(std::size_t count, int most) {
  std::vector<std::size_t> chosen(std::min(count, std::size_t(most)));
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = i * count / chosen.size();
  return chosen;
}

ViewColours gather_colours(const TrainingSet& set, const std::vector<Triangle>& triangles,
                           const PoseSurface& pose, int most, const SeeBefore& before) {
  const std::span<const TrainingView> own = own_views(set);
  ViewColours colours;
  for (const std::size_t i : evenly(own.size(), most)) {
    const TrainingView& view = own[i];
    const PosedSurface surface = pose(view);
    const std::vector<Vec3f>& posed = surface.vertices;
    colours.colour.resize(posed.size(), Vec3f::Zero()), colours.weight.resize(posed.size(), 0.f);
    colours.pictures.resize(posed.size(), 0);
    const std::vector<Vec3f> normals = vertex_normals(posed, triangles);
    const Pose cam_from_surface = view.camera.cam_from_world * surface.world_from_surface;
    const Vec3d eye = inverse(cam_from_surface).translation();
    const Raster raster = rasterise(posed, triangles, view.camera.intrinsics, cam_from_surface);
    const Raster other = before ? before(view) : Raster();
    for (std::size_t v = 0; v < posed.size(); ++v) {
      const Vec3d p = posed[v].cast<double>(), in_cam = cam_from_surface * p;
      const double facing = normals[v].cast<double>().dot((eye - p).normalized());
      if (!(in_cam.z() > 0) || !(facing > kSlantest)) continue;
      const Vec2d pixel = project<double>(view.camera.intrinsics, in_cam);
      if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < raster.width && pixel.y() < raster.height))
        continue;
      const int x = int(pixel.x()), y = int(pixel.y());
      const std::size_t pixel_index = std::size_t(y) * std::size_t(raster.width) + std::size_t(x);
      const float depth = raster.depth[pixel_index];
      if (depth == 0 || in_cam.z() > depth + kHiddenBehind) continue;
      if (before && other.depth[pixel_index] > 0 && other.depth[pixel_index] < in_cam.z()) continue;
      if (!view.alpha.empty() && view.alpha.at(x, y) < kInside) continue;
      const float weight = float(facing * facing * facing);
      const std::uint8_t* c = view.rgb.at(x, y);
      colours.colour[v] += weight / 255.f * Vec3f(c[0], c[1], c[2]);
      colours.weight[v] += weight, ++colours.pictures[v];
    }
  }
  for (std::size_t v = 0; v < colours.colour.size(); ++v)
    if (colours.weight[v] > 0) colours.colour[v] /= colours.weight[v];
  return colours;
}

}  // namespace likeness
