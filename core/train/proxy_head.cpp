// Surface, hull and colours put together.
#include "core/train/proxy_head.h"

#include <algorithm>

#include "core/image/srgb.h"
#include "core/scene/head_regions.h"
#include "core/scene/mesh_scene.h"
#include "core/train/fill_mesh.h"
#include "core/train/hair_hull.h"
#include "core/train/head_marks.h"
#include "core/train/mouth_colours.h"
#include "core/train/skin_light.h"
#include "core/train/view_colours.h"

namespace likeness {
namespace {

constexpr int kColourViews = 32, kColourRounds = 600;
constexpr float kScalp = 0.95f;      // HairHull::hairy, from which a place is coloured as hair
constexpr float kBelowBase = 0.03f;  // m of neck that are kept
// ViewColours::weight from which a colour is certain. Lips that part a little show themselves where the model
// has teeth, and hair seen at a slant shows the wall between its strands.
constexpr float kWellSeen = 0.3f, kMouthSeen = 4, kHairSeen = 3;
// ViewColours::squareness between which skin becomes certain. What stands beside skin that is seen edge-on -
// an ear, a glasses' bow, hair - lies over it by the slightest error of the fit.
constexpr float kSkinSlant = 0.2f, kSkinSquare = 0.4f;

Vec3f linear(const Vec3f& colour) {
  return {linear_of_srgb(colour[0]), linear_of_srgb(colour[1]), linear_of_srgb(colour[2])};
}

// What is spread is how light or dark a place is beside average skin that faces as it does: the sides of a
// face are not as bright as its front.
void fill_skin(const HeadModel& model, const std::vector<Vec3f>& rest,
               const std::vector<std::vector<int>>& neighbours, const std::vector<float>& known,
               const std::vector<std::uint8_t>& skin, std::vector<Vec3f>& colours) {
  const std::vector<Vec3f> normals = vertex_normals(rest, model.triangles);
  std::vector<Vec3f> light(colours.size()), relative(colours.size());
  std::vector<float> weights(colours.size());
  for (std::size_t v = 0; v < colours.size(); ++v) {
    light[v] = linear(colours[v]);
    weights[v] = skin[v] && is_skin(model, v) ? known[v] : 0.f;
  }
  const SkinLight fitted = fit_light(normals, light, weights);
  for (std::size_t v = 0; v < colours.size(); ++v)
    relative[v] = light[v].cwiseQuotient(shade(fitted, normals[v]).cwiseMax(1e-4f));
  fill_mesh(neighbours, known, skin, kColourRounds, relative);
  for (std::size_t v = 0; v < colours.size(); ++v) {
    if (!skin[v] || known[v] >= 1) continue;
    const Vec3f filled = relative[v].cwiseProduct(shade(fitted, normals[v]));
    for (int c = 0; c < 3; ++c) colours[v][c] = srgb_of_linear(std::clamp(filled[c], 0.f, 1.f));
  }
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
  seen.pictures.resize(rest.size(), 0);
  std::vector<float> known(rest.size());
  std::vector<std::uint8_t> scalp(rest.size()), skin(rest.size());
  const std::vector<std::uint8_t> mouth = inside_mouth(model);
  for (std::size_t v = 0; v < rest.size(); ++v) {
    scalp[v] = hull.hairy[v] > kScalp, skin[v] = !scalp[v];
    known[v] = std::min(1.f, seen.weight[v] / (mouth[v] ? kMouthSeen : scalp[v] ? kHairSeen : kWellSeen));
    if (skin[v] && !mouth[v])
      known[v] *= std::clamp((seen.squareness(v) - kSkinSlant) / (kSkinSquare - kSkinSlant), 0.f, 1.f);
  }
  colour_mouth(model, rest, known, proxy.colours);
  // Hair takes no colour from the skin beside it.
  const auto neighbours = vertex_neighbours(int(rest.size()), model.triangles);
  // Where no frame shows any hair, it looks like what is beside it.
  bool hair_seen = false;
  for (std::size_t v = 0; v < rest.size(); ++v) hair_seen |= scalp[v] && known[v] > 0;
  if (!hair_seen) std::ranges::fill(skin, std::uint8_t(1));
  fill_mesh(neighbours, known, scalp, kColourRounds, proxy.colours);
  fill_skin(model, rest, neighbours, known, skin, proxy.colours);
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
