// Regions of a head from its parts, its skinning and its landmark outline. See head_regions.h.
#include "core/scene/head_regions.h"

#include <algorithm>
#include <array>

#include "core/base/check.h"
#include "core/head/pose_head.h"

namespace likeness {
namespace {

using Landmarks = std::array<Vec3f, kLandmarkCount>;
using Outline = std::vector<Vec2f>;  // convex, counter-clockwise

float cross_2d(const Vec2f& a, const Vec2f& b) { return a.x() * b.y() - a.y() * b.x(); }

// Andrew's monotone chain.
Outline convex_hull(std::vector<Vec2f> points) {
  std::sort(points.begin(), points.end(),
            [](const Vec2f& a, const Vec2f& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  Outline hull;
  const auto add_chain = [&hull](auto first, auto last) {
    const std::size_t start = hull.size();
    for (auto point = first; point != last; ++point) {
      while (hull.size() >= start + 2 &&
             cross_2d(hull.back() - hull[hull.size() - 2], *point - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(*point);
    }
    hull.pop_back();  // begins the other chain
  };
  add_chain(points.begin(), points.end());
  add_chain(points.rbegin(), points.rend());
  return hull;
}

bool inside(const Outline& hull, const Vec2f& point) {
  for (std::size_t i = 0; i < hull.size(); ++i)
    if (cross_2d(hull[(i + 1) % hull.size()] - hull[i], point - hull[i]) < 0) return false;
  return true;
}

// Frontal outline of the face: the landmarks' hull, with the brows mirrored upward for the forehead by two
// thirds of the height from the nose's tip to the brows (landmarks stop at the brows).
Outline face_outline(const Landmarks& landmarks) {
  std::vector<Vec2f> points;
  for (const Vec3f& landmark : landmarks) points.push_back(landmark.head<2>());
  float brow = 0;
  for (int l = 17; l < 27; ++l) brow += landmarks[l].y() / 10;
  const float rise = (brow - landmarks[30].y()) * 2 / 3;
  for (int l = 17; l < 27; ++l) points.push_back(landmarks[l].head<2>() + Vec2f(0, rise));
  return convex_hull(std::move(points));
}

// Height of the cut between head and neck at depth z, template coordinates: a line from under the chin up
// through under the jaw's corners, no higher at the back than the mouth.
struct NeckCut {
  float chin_y = 0, chin_z = 0, slope = 0, top = 0;
  float height(float z) const { return std::min(chin_y + slope * (chin_z - z), top); }
};

NeckCut neck_cut(const Landmarks& landmarks) {
  const float scale = (landmarks[45] - landmarks[36]).norm();  // outer eye corners, about 9 cm
  const Vec3f chin = landmarks[8] - Vec3f(0, 0.12f * scale, 0);
  const Vec3f corner = (landmarks[4] + landmarks[12]) / 2 - Vec3f(0, 0.15f * scale, 0);
  NeckCut cut;
  cut.chin_y = chin.y();
  cut.chin_z = chin.z();
  cut.slope = chin.z() - corner.z() > 0.1f * scale
                  ? std::max(0.0f, (corner.y() - chin.y()) / (chin.z() - corner.z()))
                  : 0;
  cut.top = (landmarks[48].y() + landmarks[54].y()) / 2;
  return cut;
}

bool is_mouth_interior(HeadPart part) {
  return part == HeadPart::mouth_socket || part == HeadPart::gums_tongue || part == HeadPart::teeth;
}
bool is_eyeball(HeadPart part) { return part == HeadPart::left_eyeball || part == HeadPart::right_eyeball; }
bool is_eye_socket(HeadPart part) {
  return part == HeadPart::left_eye_socket || part == HeadPart::right_eye_socket;
}

}  // namespace

HeadRegions head_regions(const HeadModel& model) {
  LIKENESS_CHECK(int(model.parts.size()) == model.vertex_count(), "%d parts for %d vertices",
                 int(model.parts.size()), model.vertex_count());
  const Landmarks landmarks = landmark_positions(model, model.vertices);
  const Outline outline = face_outline(landmarks);
  const NeckCut cut = neck_cut(landmarks);
  const float back = std::min(landmarks[0].z(), landmarks[16].z());  // the ears: there is no face behind them

  const std::size_t count = model.triangles.size();
  const std::vector<std::uint8_t> nowhere(count);
  HeadRegions regions{
      .face = nowhere, .head = nowhere, .mouth_interior = nowhere, .eyes = nowhere, .skin = nowhere};
  for (std::size_t t = 0; t < count; ++t) {
    const Triangle& triangle = model.triangles[t];
    const Vec3f centre =
        (model.vertices[triangle[0]] + model.vertices[triangle[1]] + model.vertices[triangle[2]]) / 3;
    // A triangle across two parts belongs to the inner one only if all of it does.
    const auto all = [&](auto predicate) {
      return predicate(model.parts[triangle[0]]) && predicate(model.parts[triangle[1]]) &&
             predicate(model.parts[triangle[2]]);
    };
    const bool torso = all([](HeadPart part) { return part == HeadPart::torso; });
    const bool mouth = all(is_mouth_interior), eyes = all(is_eyeball);
    regions.mouth_interior[t] = mouth;
    regions.eyes[t] = eyes;
    regions.skin[t] = !mouth && !eyes && !all(is_eye_socket);
    regions.head[t] = !torso && (mouth || eyes || centre.y() > cut.height(centre.z()));
    regions.face[t] =
        !torso &&
        (mouth || eyes ||
         (centre.z() >= back && inside(outline, centre.head<2>()) && centre.y() > cut.height(centre.z())));
  }
  return regions;
}

std::vector<int> region_vertices(const HeadModel& model, const std::vector<std::uint8_t>& triangles) {
  std::vector<std::uint8_t> used(model.vertices.size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (triangles[t])
      for (int k = 0; k < 3; ++k) used[model.triangles[t][k]] = 1;
  std::vector<int> vertices;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v]) vertices.push_back(int(v));
  return vertices;
}

std::vector<Triangle> region_triangles(const HeadModel& model, const std::vector<std::uint8_t>& triangles,
                                       std::vector<int>* source) {
  LIKENESS_CHECK(triangles.size() == model.triangles.size(), "%d flags for %d triangles",
                 int(triangles.size()), int(model.triangles.size()));
  std::vector<Triangle> kept;
  if (source) source->clear();
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!triangles[t]) continue;
    kept.push_back(model.triangles[t]);
    if (source) source->push_back(int(t));
  }
  return kept;
}

std::vector<std::vector<int>> vertex_neighbours(int vertex_count, const std::vector<Triangle>& triangles) {
  std::vector<std::vector<int>> neighbours(static_cast<std::size_t>(vertex_count));
  for (const Triangle& triangle : triangles)
    for (int k = 0; k < 3; ++k) {
      neighbours[triangle[k]].push_back(triangle[(k + 1) % 3]);
      neighbours[triangle[k]].push_back(triangle[(k + 2) % 3]);
    }
  for (std::vector<int>& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbours;
}

}  // namespace likeness
