// See attribute_region.h.
#include "core/train/attribute_region.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

constexpr float kBehind = 0.004f;  // m by which a vertex may lie behind the surface seen at its pixel
constexpr float kPainted = 0.5f;
constexpr int kMostNodes = 64;  // along an axis

// Falls from 1 at `from` to 0 at `to`.
float fade(float value, float from, float to) {
  const float t = std::clamp((value - from) / (to - from), 0.f, 1.f);
  return 1 - t * t * (3 - 2 * t);
}

}  // namespace

std::vector<float> carry_paint(const HeadModel& model, std::span<const Vec3f> posed, const Camera& camera,
                               const Pose& world_from_head, const Image& cover) {
  LIKENESS_CHECK(cover.channels == 1 && cover.width == camera.intrinsics.width &&
                     cover.height == camera.intrinsics.height && int(posed.size()) == model.vertex_count(),
                 "a cover of %dx%d for a picture of %dx%d", cover.width, cover.height,
                 camera.intrinsics.width, camera.intrinsics.height);
  const Pose cam_from_head = camera.cam_from_world * world_from_head;
  const Raster seen = rasterise(posed, model.triangles, camera.intrinsics, cam_from_head);
  std::vector<float> paint(posed.size(), 0.f);
  for (std::size_t v = 0; v < posed.size(); ++v) {
    const Vec3d p = cam_from_head * posed[v].cast<double>();
    if (p.z() < 1e-3) continue;
    const Vec2d pixel = project(camera.intrinsics, p);
    const int x = int(std::floor(pixel.x())), y = int(std::floor(pixel.y()));
    if (x < 0 || y < 0 || x >= cover.width || y >= cover.height) continue;
    const float depth = seen.depth[std::size_t(y) * std::size_t(cover.width) + std::size_t(x)];
    if (depth > 0 && float(p.z()) < depth + kBehind) paint[v] = *cover.at(x, y);
  }
  return paint;
}

std::vector<float> distance_to_paint(std::span<const Vec3f> rest, std::span<const float> paint) {
  std::vector<Vec3f> painted;
  for (std::size_t v = 0; v < rest.size(); ++v)
    if (paint[v] >= kPainted) painted.push_back(rest[v]);
  std::vector<float> distance(rest.size(), std::numeric_limits<float>::infinity());
  parallel_for(rest.size(), [&](std::size_t v) {
    float nearest = std::numeric_limits<float>::infinity();
    for (const Vec3f& p : painted) nearest = std::min(nearest, (p - rest[v]).squaredNorm());
    distance[v] = std::sqrt(nearest);
  });
  return distance;
}

std::vector<float> soft_weights(std::span<const float> distance, const RegionOptions& options) {
  std::vector<float> weights;
  for (const float d : distance) weights.push_back(fade(d, 0, options.rim));
  return weights;
}

AttributeRegion make_region(const std::string& name, const HeadModel& model, std::span<const Vec3f> rest,
                            std::span<const float> weights, const RegionOptions& options) {
  AttributeRegion region;
  region.name = name;
  Vec3f low = Vec3f::Constant(1e9f), high = -low;
  for (std::size_t v = 0; v < rest.size(); ++v)
    if (weights[v] > 0) low = low.cwiseMin(rest[v]), high = high.cwiseMax(rest[v]);
  LIKENESS_CHECK((high - low).minCoeff() >= 0, "a region of '%s' without a vertex", name.c_str());
  const float margin = options.far + options.cell;
  low -= Vec3f::Constant(margin), high += Vec3f::Constant(margin);
  region.cell = std::max(options.cell, (high - low).maxCoeff() / float(kMostNodes - 2));
  region.origin = low;
  for (int a = 0; a < 3; ++a)
    region.count[std::size_t(a)] = 2 + int(std::ceil((high[a] - low[a]) / region.cell));
  const int nx = region.count[0], ny = region.count[1], nz = region.count[2];
  region.weights.assign(std::size_t(nx) * std::size_t(ny) * std::size_t(nz), 0);
  const MeshScene face({rest.begin(), rest.end()}, model.triangles);
  parallel_for(std::size_t(nz), [&](std::size_t z) {
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        if (x == 0 || y == 0 || z == 0 || x == nx - 1 || y == ny - 1 || int(z) == nz - 1) continue;
        const Vec3f at = region.origin + region.cell * Vec3f(float(x), float(y), float(z));
        const auto nearest = face.closest(at, options.far);
        if (!nearest) continue;
        const Triangle& t = model.triangles[std::size_t(nearest->triangle)];
        float weight = 0;
        for (int corner = 0; corner < 3; ++corner)
          weight += nearest->barycentric[corner] * weights[std::size_t(t[std::size_t(corner)])];
        weight *= fade(nearest->distance, options.reach, options.far);
        region.weights[(z * std::size_t(ny) + std::size_t(y)) * std::size_t(nx) + std::size_t(x)] =
            std::uint8_t(std::lround(255 * std::clamp(weight, 0.f, 1.f)));
      }
  });
  return region;
}

}  // namespace likeness
