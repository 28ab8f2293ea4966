// Where the scalp is seen edge-on, the matte's end tells the thickness. The hairline is told by colour: the
// head's top is hair or a bald head, and both look different from the cheeks or need no hull.
#include "core/train/hair_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/scene/head_regions.h"
#include "core/train/fill_mesh.h"
#include "core/train/head_marks.h"
#include "core/train/view_colours.h"

namespace likeness {
namespace {

constexpr int kEdgeViews = 24, kHairlineViews = 12;
constexpr std::size_t kLeastViews = 3;                                    // that see a vertex edge-on
constexpr double kMostHair = 0.065, kMatteStep = 0.001, kInwards = 0.01;  // m
constexpr double kEdgeOn = 0.2;                                           // cosine of normal and view
constexpr float kAboveBrow = 0.02f;  // m: ears end there; below, it is they that stand against the background
constexpr float kBesideEars = 0.008f;  // m of hair there, at most
constexpr float kFade = 0.02f;         // m
constexpr int kHullRounds = 400, kSmoothRounds = 6;
constexpr float kLeastContrast = 0.15f;  // between hair and skin, of encoded colours
constexpr int kNoseTip = 30, kNoseBridge = 28, kNoseRoot = 33;

// The vertices joined to the face: ears may be pieces of their own.
std::vector<std::uint8_t> joined_to_face(const HeadModel& model,
                                         const std::vector<std::vector<int>>& neighbours) {
  std::vector<std::uint8_t> joined(neighbours.size(), 0);
  std::vector<int> stack{model.triangles[std::size_t(model.landmark_triangle[kNoseTip])][0]};
  joined[std::size_t(stack[0])] = 1;
  while (!stack.empty()) {
    const int v = stack.back();
    stack.pop_back();
    for (const int n : neighbours[std::size_t(v)])
      if (!joined[std::size_t(n)]) joined[std::size_t(n)] = 1, stack.push_back(n);
  }
  return joined;
}

// Scalp by its place alone.
std::vector<float> hairy_by_place(const HeadModel& model, const std::vector<Vec3f>& rest,
                                  const HeadMarks& marks, const std::vector<std::vector<int>>& neighbours) {
  const auto landmarks = landmark_positions(model, rest);
  const std::vector<std::uint8_t> joined = joined_to_face(model, neighbours);
  std::vector<float> hairy(rest.size(), 0.f);
  for (std::size_t v = 0; v < rest.size(); ++v) {
    if (!is_skin(model, v) || !joined[v]) continue;
    const Vec3f& p = rest[v];
    const Vec3f& side = p.x() * landmarks[0].x() > 0 ? landmarks[0] : landmarks[16];
    const bool ear = std::abs(p.x()) > std::abs(side.x()) && p.y() > marks.nose - 0.025f &&
                     p.y() < marks.brow + kAboveBrow && p.z() > side.z() - 0.05f && p.z() < side.z() + 0.005f;
    if (!ear) hairy[v] = hairiness(marks, p);
  }
  return hairy;
}

// A forehead's skin goes on above the brows: no hair where a place looks like the cheeks rather than like the
// top of the head.
void find_hairline(const TrainingSet& set, const HeadShape& shape, const std::vector<Triangle>& triangles,
                   const std::vector<Vec3f>& rest, std::vector<float>& hairy) {
  const auto pose = [&](const TrainingView& view) {
    return PosedSurface{pose_head(set.model, shape, view.pose.articulation), view.pose.world_from_head};
  };
  const ViewColours seen = gather_colours(set, triangles, pose, kHairlineViews);
  if (seen.colour.empty()) return;
  const auto landmarks = landmark_positions(set.model, rest);
  float top = -1e9f;
  for (std::size_t v = 0; v < hairy.size(); ++v)
    if (hairy[v] > 0) top = std::max(top, rest[v].y());
  std::array<std::vector<double>, 3> hair, skin;
  for (std::size_t v = 0; v < hairy.size(); ++v) {
    if (seen.weight[v] <= 0) continue;
    const bool upper = hairy[v] > 0.9f && rest[v].y() > top - 0.04f;
    const bool cheek = is_skin(set.model, v) && hairy[v] == 0 && rest[v].y() < landmarks[kNoseBridge].y() &&
                       rest[v].y() > landmarks[kNoseRoot].y() && std::abs(rest[v].x()) > 0.02f;
    for (std::size_t c = 0; c < 3; ++c) {
      if (upper) hair[c].push_back(seen.colour[v][Eigen::Index(c)]);
      if (cheek) skin[c].push_back(seen.colour[v][Eigen::Index(c)]);
    }
  }
  if (hair[0].size() < 20 || skin[0].size() < 20) return;
  Vec3f of_hair, of_skin;
  for (std::size_t c = 0; c < 3; ++c)
    of_hair[Eigen::Index(c)] = float(median(hair[c])), of_skin[Eigen::Index(c)] = float(median(skin[c]));
  if ((of_hair - of_skin).norm() < kLeastContrast) return;
  for (std::size_t v = 0; v < hairy.size(); ++v) {
    if (hairy[v] <= 0 || seen.weight[v] < 0.3f) continue;
    const float to_skin = (seen.colour[v] - of_skin).norm(), to_hair = (seen.colour[v] - of_hair).norm();
    hairy[v] *= std::clamp((to_skin / std::max(1e-6f, to_skin + to_hair) - 0.4f) / 0.2f, 0.f, 1.f);
  }
}

// How far outwards the matte is person, m; nullopt where the place or what lies beyond it was not filmed.
std::optional<double> reach_of(const TrainingView& view, const Pose& cam_from_head, const Vec3d& p,
                               const Vec3d& outwards) {
  double reached = 0;
  for (double h = -kInwards; h <= kMostHair; h += kMatteStep) {
    const Vec2d pixel = project<double>(view.camera.intrinsics, Vec3d(cam_from_head * (p + h * outwards)));
    if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < view.alpha.width && pixel.y() < view.alpha.height))
      return std::nullopt;
    if (!view.inside.empty() && !view.inside.contains(int(pixel.x()), int(pixel.y()))) return std::nullopt;
    if (view.alpha.at(int(pixel.x()), int(pixel.y())) < 128) return reached;
    reached = std::max(0.0, h);
  }
  return reached;
}

// Median over the views that see a vertex edge-on; known: 1 where there are enough.
void measure_edges(const TrainingSet& set, const HeadShape& shape, const std::vector<float>& hairy,
                   std::vector<float>& thickness, std::vector<float>& known) {
  const std::span<const TrainingView> own = own_views(set);
  std::vector<std::vector<double>> reaches(hairy.size());
  for (const std::size_t i : evenly(own.size(), kEdgeViews)) {
    const TrainingView& view = own[i];
    if (view.alpha.empty()) continue;
    const std::vector<Vec3f> posed = pose_head(set.model, shape, view.pose.articulation);
    const std::vector<Vec3f> normals = vertex_normals(posed, set.model.triangles);
    const Pose cam_from_head = view.camera.cam_from_world * view.pose.world_from_head;
    const Vec3d eye = inverse(cam_from_head).translation();
    for (std::size_t v = 0; v < posed.size(); ++v) {
      if (hairy[v] < 0.3f) continue;
      const Vec3d p = posed[v].cast<double>(), normal = normals[v].cast<double>();
      if (std::abs(normal.dot((eye - p).normalized())) > kEdgeOn) continue;
      if (const auto reach = reach_of(view, cam_from_head, p, normal)) reaches[v].push_back(*reach);
    }
  }
  for (std::size_t v = 0; v < reaches.size(); ++v)
    if (reaches[v].size() >= kLeastViews) thickness[v] = float(median(reaches[v])), known[v] = 1;
}

}  // namespace

HairHull make_hair_hull(const TrainingSet& set, const HeadShape& shape,
                        const std::vector<Triangle>& triangles) {
  const HeadModel& model = set.model;
  const std::vector<Vec3f> rest = pose_head(model, shape, neutral_articulation(model));
  const HeadMarks marks = head_marks(model, shape);
  const auto neighbours = vertex_neighbours(int(rest.size()), model.triangles);
  HairHull hull;
  hull.hairy = hairy_by_place(model, rest, marks, neighbours);
  find_hairline(set, shape, triangles, rest, hull.hairy);
  hull.thickness.assign(rest.size(), 0.f);
  std::vector<float> known(rest.size(), 0.f);
  measure_edges(set, shape, hull.hairy, hull.thickness, known);
  const float ears_end = marks.brow + kAboveBrow;
  std::vector<std::uint8_t> scalp(rest.size(), 0);
  for (std::size_t v = 0; v < rest.size(); ++v) {
    scalp[v] = hull.hairy[v] > 0;
    if (rest[v].y() < ears_end || !scalp[v]) hull.thickness[v] = 0, known[v] = 0;
  }
  fill_mesh(neighbours, known, scalp, kHullRounds, hull.thickness);
  // Steps between measured neighbours.
  std::vector<float> partly(known.size(), 0.5f);
  fill_mesh(neighbours, partly, scalp, kSmoothRounds, hull.thickness);
  const float half_width = 0.5f * std::abs(landmark_positions(model, rest)[0].x());
  for (std::size_t v = 0; v < rest.size(); ++v) {
    hull.thickness[v] *= std::min(1.f, 1.5f * hull.hairy[v]);
    if (std::abs(rest[v].x()) < half_width) continue;
    const float beside = std::clamp((ears_end - rest[v].y()) / kFade, 0.f, 1.f);
    const float most = float(kMostHair) + beside * (kBesideEars - float(kMostHair));
    hull.thickness[v] = std::min(hull.thickness[v], most);
  }
  return hull;
}

}  // namespace likeness
