// Surface, hull and colours put together.
#include "core/train/proxy_head.h"

#include <algorithm>

#include "core/scene/head_regions.h"
#include "core/scene/mesh_scene.h"
#include "core/train/fill_mesh.h"
#include "core/train/hair_hull.h"
#include "core/train/head_marks.h"
#include "core/train/mouth_colours.h"
#include "core/train/view_colours.h"

namespace likeness {
namespace {

constexpr int kColourViews = 32, kColourRounds = 600;
constexpr float kScalp = 0.95f;      // HairHull::hairy, from which a place is coloured as hair
constexpr float kBelowBase = 0.03f;  // m of neck that are kept
// ViewColours::weight from which a colour is certain. Lips that part a little show themselves where the model
// has teeth.
constexpr float kWellSeen = 0.3f, kMouthSeen = 4;

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
  proxy.base = marks.base, proxy.brow = marks.brow, proxy.axis_z = neck_axis(model, shape);
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
  const std::vector<std::uint8_t> mouth = inside_mouth(model);
  for (std::size_t v = 0; v < rest.size(); ++v) {
    known[v] = std::min(1.f, seen.weight[v] / (mouth[v] ? kMouthSeen : kWellSeen));
    scalp[v] = hull.hairy[v] > kScalp, skin[v] = !scalp[v];
  }
  colour_mouth(model, rest, known, proxy.colours);
  // Hair takes no colour from the skin beside it.
  const auto neighbours = vertex_neighbours(int(rest.size()), model.triangles);
  // Where no frame shows any hair, it looks like what is beside it.
  bool hair_seen = false;
  for (std::size_t v = 0; v < rest.size(); ++v) hair_seen |= scalp[v] && known[v] > 0;
  if (!hair_seen) std::ranges::fill(skin, std::uint8_t(1));
  for (const auto* part : {&scalp, &skin}) fill_mesh(neighbours, known, *part, kColourRounds, proxy.colours);
  const ProxyPart part = head_part(model, proxy);
  const ProxyPart* const alone = &part;
  const auto unexplained_above = [&](double height) {
    return unexplained(set, {&alone, 1}, [&](const TrainingView& view) {
      return std::vector{above_place(view, view.pose.world_from_head, {0, height, marks.ear_z})};
    });
  };
  proxy.unexplained = unexplained_above(marks.chin);
  proxy.crown_unexplained = unexplained_above(marks.brow);
  return proxy;
}

}  // namespace likeness
