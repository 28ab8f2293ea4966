// Light of the room: per patch a grid of about 8 cm, gathered once; a look-up then costs one ray and one
// evaluation of a paint.
#include "core/synth/room.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/scene/mesh_scene.h"
#include "core/synth/noise.h"

namespace likeness {
namespace {

MeshScene scene_of(const std::vector<RoomPatch>& patches) {
  std::vector<Vec3f> vertices;
  std::vector<Triangle> triangles;
  for (const RoomPatch& p : patches) {
    const int first = int(vertices.size());
    for (const Vec3f& corner :
         {p.origin, Vec3f(p.origin + p.u), Vec3f(p.origin + p.u + p.v), Vec3f(p.origin + p.v)}) {
      vertices.push_back(corner);
    }
    triangles.push_back(Triangle(first, first + 1, first + 2));
    triangles.push_back(Triangle(first, first + 2, first + 3));
  }
  return MeshScene(std::move(vertices), std::move(triangles));
}

struct LightGrid {
  int columns = 2, rows = 2;
  std::vector<Vec3f> light;  // (rows, columns), at s = column / (columns - 1)

  Vec3f at(float s, float t) const {
    const float x = s * float(columns - 1), y = t * float(rows - 1);
    const int i = std::clamp(int(x), 0, columns - 2), j = std::clamp(int(y), 0, rows - 2);
    const float a = x - float(i), b = y - float(j);
    const Vec3f* row = light.data() + j * columns + i;
    return mix(mix(row[0], row[1], a), mix(row[columns], row[columns + 1], a), b);
  }
};

}  // namespace

struct Room::Impl {
  std::vector<RoomPatch> patches;
  MeshScene scene;
  std::vector<LightGrid> grids;
  Vec3f outdoors = Vec3f::Ones();

  explicit Impl(std::vector<RoomPatch> p) : patches(std::move(p)), scene(scene_of(patches)) {}
};

Room::Room(std::vector<RoomPatch> patches, const LightRig& rig)
    : impl_(std::make_unique<Impl>(std::move(patches))) {
  impl_->outdoors = rig.outdoors;
  impl_->grids.resize(impl_->patches.size());
  const Visible visible = [this](const Vec3f& from, const Vec3f& direction, float distance) {
    return !impl_->scene.occluded(from, direction, 1e-4f, distance);
  };
  GatherOptions gather;
  gather.light_grid = 2;
  gather.sky_rays = 16;
  gather.sky_reach = 0.6f;
  gather.bounce = 0.35f;
  gather.bounce_colour = Vec3f(1.0f, 0.9f, 0.8f);
  parallel_for(impl_->patches.size(), [&](std::size_t index) {
    const RoomPatch& p = impl_->patches[index];
    const bool blank = p.paint == RoomPaint::blank;
    GatherOptions how = gather;
    if (blank) how.light_grid = 12, how.sky_rays = 512;  // or its noise would be a texture
    LightGrid& grid = impl_->grids[index];
    grid.columns = std::clamp(int(p.u.norm() / 0.08f) + 1, 2, blank ? 80 : 40);
    grid.rows = std::clamp(int(p.v.norm() / 0.08f) + 1, 2, 40);
    grid.light.resize(std::size_t(grid.columns) * grid.rows);
    const Vec3f normal = p.u.cross(p.v).normalized();
    for (int j = 0; j < grid.rows; ++j) {
      for (int i = 0; i < grid.columns; ++i) {
        // A little inside the edge, so that a neighbouring patch does not swallow the point.
        const float s = std::clamp(float(i) / float(grid.columns - 1), 0.02f, 0.98f);
        const float t = std::clamp(float(j) / float(grid.rows - 1), 0.02f, 0.98f);
        const Vec3f at = p.origin + s * p.u + t * p.v;
        const std::uint32_t pattern = std::uint32_t(index * 4096 + std::size_t(j) * 64 + i);
        grid.light[std::size_t(j) * grid.columns + i] =
            gather_light(rig, Vec3f::UnitY(), at + 0.001f * normal, normal, visible, how, pattern).diffuse;
      }
    }
  });
}

Room::~Room() = default;
Room::Room(Room&&) noexcept = default;
Room& Room::operator=(Room&&) noexcept = default;

Vec3f Room::look(const Vec3f& origin, const Vec3f& direction) const {
  const auto hit = impl_->scene.intersect(origin, direction, 0.05f);
  if (!hit) return Vec3f(0.05f, 0.05f, 0.05f);
  const std::size_t index = std::size_t(hit->triangle) / 2;
  const float b1 = hit->barycentric.x(), b2 = hit->barycentric.y();
  const float s = hit->triangle % 2 == 0 ? b1 + b2 : b1, t = hit->triangle % 2 == 0 ? b2 : b1 + b2;
  const RoomPatch& patch = impl_->patches[index];
  const Vec3f albedo = paint_patch(patch, s, t).cwiseMax(0.0f);
  if (patch.glow > 0) return patch.glow * albedo.cwiseProduct(impl_->outdoors);
  return albedo.cwiseProduct(impl_->grids[index].at(s, t));
}

}  // namespace likeness
