// Surface, hull and colours put together.
#include "core/train/proxy_head.h"

#include <algorithm>

#include "core/scene/head_regions.h"
#include "core/scene/mesh_scene.h"
#include "core/train/fill_mesh.h"
#include "core/train/hair_hull.h"
#include "core/train/head_marks.h"
#include "core/train/view_colours.h"

namespace likeness {
namespace {

constexpr int kColourViews = 32, kExplainViews = 8, kColourRounds = 600;
constexpr float kScalp = 0.95f;      // HairHull::hairy, from which a place is coloured as hair
constexpr float kBelowBase = 0.03f;  // m of neck that are kept
constexpr float kWellSeen = 0.3f;    // ViewColours::weight from which a colour is certain

// Share of the mattes above a height of the head at rest that lies outside the proxy.
double unexplained_above(const TrainingSet& set, const ProxyHead& proxy, const Vec3f& height) {
  const std::span<const TrainingView> own = own_views(set);
  std::size_t person = 0, outside = 0;
  for (const std::size_t i : evenly(own.size(), kExplainViews)) {
    const TrainingView& view = own[i];
    if (view.alpha.empty()) continue;
    const Pose cam_from_head = view.camera.cam_from_world * view.pose.world_from_head;
    const Image8 mask = silhouette(pose_proxy(set.model, proxy, view.pose.articulation), proxy.triangles,
                                   view.camera.intrinsics, cam_from_head);
    const Vec2d from = project<double>(view.camera.intrinsics, Vec3d(cam_from_head * height.cast<double>()));
    const Vec2d up = (cam_from_head.linear() * Vec3d::UnitY()).head<2>();
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x) {
        if (view.alpha.at(x, y) < 128 || (Vec2d(x + 0.5, y + 0.5) - from).dot(up) < 0) continue;
        ++person, outside += *mask.at(x, y) == 0;
      }
  }
  return person > 0 ? double(outside) / double(person) : 1;
}

}  // namespace

std::vector<Vec3f> pose_proxy(const HeadModel& model, const ProxyHead& proxy,
                              const Articulation& articulation) {
  std::vector<Vec3f> vertices = pose_head(model, proxy.shape, articulation);
  const std::vector<Vec3f> normals = vertex_normals(vertices, model.triangles);
  for (std::size_t v = 0; v < vertices.size(); ++v) vertices[v] += proxy.hair[v] * normals[v];
  return vertices;
}

ProxyPart head_part(const HeadModel& model, const ProxyHead& proxy) {
  return {proxy.triangles, proxy.colours, [&model, &proxy](const TrainingView& view) {
            return PosedSurface{pose_proxy(model, proxy, view.pose.articulation), view.pose.world_from_head};
          }};
}

ProxyHead make_proxy_head(const TrainingSet& set, const HeadShape& shape) {
  const HeadModel& model = set.model;
  const std::vector<Vec3f> rest = pose_head(model, shape, neutral_articulation(model));
  ProxyHead proxy;
  proxy.shape = shape;
  const HeadMarks marks = head_marks(model, shape);
  proxy.base = marks.base, proxy.brow = marks.brow;
  for (const Triangle& t : model.triangles)
    if (rest[std::size_t(t[0])].y() > proxy.base - kBelowBase) proxy.triangles.push_back(t);
  const HairHull hull = make_hair_hull(set, shape, proxy.triangles);
  proxy.hair = hull.thickness;
  const auto pose = [&](const TrainingView& view) {
    return PosedSurface{pose_proxy(model, proxy, view.pose.articulation), view.pose.world_from_head};
  };
  ViewColours seen = gather_colours(set, proxy.triangles, pose, kColourViews);
  proxy.colours = std::move(seen.colour);
  proxy.colours.resize(rest.size(), Vec3f::Zero()), seen.weight.resize(rest.size(), 0.f);
  std::vector<float> known(rest.size());
  std::vector<std::uint8_t> scalp(rest.size()), skin(rest.size());
  for (std::size_t v = 0; v < rest.size(); ++v) {
    known[v] = std::min(1.f, seen.weight[v] / kWellSeen);
    scalp[v] = hull.hairy[v] > kScalp, skin[v] = !scalp[v];
  }
  // Hair takes no colour from the skin beside it.
  const auto neighbours = vertex_neighbours(int(rest.size()), model.triangles);
  // Where no frame shows any hair, it looks like what is beside it.
  bool hair_seen = false;
  for (std::size_t v = 0; v < rest.size(); ++v) hair_seen |= scalp[v] && known[v] > 0;
  if (!hair_seen) std::ranges::fill(skin, std::uint8_t(1));
  for (const auto* part : {&scalp, &skin}) fill_mesh(neighbours, known, *part, kColourRounds, proxy.colours);
  proxy.unexplained = unexplained_above(set, proxy, {0, marks.chin, marks.ear_z});
  proxy.crown_unexplained = unexplained_above(set, proxy, {0, marks.brow, marks.ear_z});
  return proxy;
}

}  // namespace likeness
