// Parts by landmarks of the head at rest.
#include "core/holds/skin_parts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/rigid.h"
#include "core/scene/head_regions.h"

namespace likeness {
namespace {

constexpr float kBrowWidth = 0.008f;  // m from the brows' middle to the skin above them
constexpr float kBesideNose = 0.003f, kBesideMouth = 0.006f, kBelowEyes = 0.006f, kBelowLip = 0.006f;
constexpr float kAboutLips = 0.004f;  // m beyond the lips' outline

struct Marks {
  float brow = -1e9f, eyes = 0, nose_top = 0, nose_base = 0, nose_left = 0, nose_right = 0;
  float mouth_left = 0, mouth_right = 0, mouth_top = 0, mouth_base = 0, middle = 0;
};

Marks marks_of(const HeadModel& model, const std::vector<Vec3f>& resting) {
  const auto l = landmark_positions(model, resting);
  Marks m;
  for (std::size_t i = 17; i <= 26; ++i) m.brow = std::max(m.brow, l[i].y());
  m.brow += kBrowWidth;
  m.eyes = std::min({l[40].y(), l[41].y(), l[46].y(), l[47].y()}) - kBelowEyes;
  m.nose_top = l[27].y(), m.nose_base = l[33].y(), m.middle = l[33].x();
  m.nose_left = std::max(l[31].x(), l[35].x()) + kBesideNose;
  m.nose_right = std::min(l[31].x(), l[35].x()) - kBesideNose;
  m.mouth_left = std::max(l[48].x(), l[54].x()), m.mouth_right = std::min(l[48].x(), l[54].x());
  m.mouth_top = std::max({l[50].y(), l[51].y(), l[52].y()}), m.mouth_base = l[57].y();
  return m;
}

SkinPart part_at(const Marks& m, const Vec3f& p) {
  if (p.y() > m.brow) return SkinPart::forehead;
  if (p.x() > m.nose_right && p.x() < m.nose_left) {
    if (p.y() < m.nose_top && p.y() > m.nose_base) return SkinPart::nose;
    return p.y() < m.mouth_base - kBelowLip ? SkinPart::chin : SkinPart::none;
  }
  if (p.y() > m.eyes) return SkinPart::none;
  if (p.y() < m.nose_base && p.x() > m.mouth_right - kBesideMouth && p.x() < m.mouth_left + kBesideMouth)
    return p.y() < m.mouth_base - kBelowLip ? SkinPart::chin : SkinPart::none;
  return p.x() > m.middle ? SkinPart::left_cheek : SkinPart::right_cheek;
}

bool about_lips(const Marks& m, const Vec3f& p) {
  return p.x() > m.mouth_right - kAboutLips && p.x() < m.mouth_left + kAboutLips &&
         p.y() > m.mouth_base - kAboutLips && p.y() < m.mouth_top + kAboutLips;
}

}  // namespace

SkinMap make_skin_map(const HeadModel& model, const std::vector<Vec3f>& resting) {
  const HeadRegions regions = head_regions(model);
  const Marks marks = marks_of(model, resting);
  const std::size_t count = model.triangles.size();
  SkinMap map;
  map.part.assign(count, SkinPart::none);
  map.skin.assign(count, 0), map.head = regions.head, map.mouth = regions.mouth_interior;
  map.eyes = regions.eyes;
  map.lips.assign(count, 0), map.drawn.assign(count, 0);
  for (std::size_t t = 0; t < count; ++t) {
    const Triangle& triangle = model.triangles[t];
    const bool bust =
        std::ranges::all_of(triangle, [&](int v) { return model.parts[std::size_t(v)] == HeadPart::torso; });
    if (!bust) {
      map.drawn[t] = 1;
      map.triangles.push_back(triangle);
      map.of_drawn.push_back(std::int32_t(t));
    }
    if (!regions.face[t] || !regions.skin[t] || regions.eyes[t] || regions.mouth_interior[t]) continue;
    Vec3f middle = Vec3f::Zero();
    for (const int v : triangle) middle += resting[std::size_t(v)] / 3;
    map.skin[t] = 1;
    map.part[t] = part_at(marks, middle);
    map.lips[t] = about_lips(marks, middle);
  }
  std::vector<std::uint8_t> forehead(count, 0);
  for (std::size_t t = 0; t < count; ++t) forehead[t] = map.part[t] == SkinPart::forehead;
  map.forehead_vertices = region_vertices(model, forehead);
  return map;
}

double HeadInPicture::facing(const Vec3f& point, const Vec3f& normal) const {
  const Vec3d to_eye = inverse(cam_from_head).translation() - point.cast<double>();
  return normal.cast<double>().normalized().dot(to_eye.normalized());
}

HeadInPicture head_in_picture(const HeadModel& model, const SkinMap& map, std::vector<Vec3f> posed,
                              const Intrinsics& intrinsics, const Pose& cam_from_head) {
  HeadInPicture head;
  head.map = &map;
  head.posed = std::move(posed);
  head.normals = vertex_normals(head.posed, model.triangles);
  head.intrinsics = intrinsics, head.cam_from_head = cam_from_head;
  head.raster = rasterise(head.posed, map.triangles, intrinsics, cam_from_head);
  return head;
}

Image8 seen_mask(const HeadInPicture& head, const std::vector<std::uint8_t>& triangles) {
  Image8 mask(head.raster.width, head.raster.height, 1);
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    const int t = head.triangle(i);
    if (t >= 0 && triangles[std::size_t(t)]) mask.data[i] = 255;
  }
  return mask;
}

}  // namespace likeness
