// Both halves of the built-in head, and the operations its displacement fields are made of.
#include "core/head/builtin_fields.h"

#include <cmath>
#include <numbers>

#include "core/head/builtin_sculpt.h"

namespace likeness::builtin {

WholeHead make_whole_head() {
  WholeHead head;
  head.skin = make_skin();
  HalfMesh half = head.skin.mesh;
  append(half, make_eyeball());
  append(half, make_ear());
  append(half, make_teeth(true));
  append(half, make_teeth(false));
  append(half, make_tongue());
  head.left_count = int(half.vertices.size());
  head.vertices = half.vertices;
  head.triangles = half.triangles;
  head.twin.resize(half.vertices.size());
  for (int i = 0; i < head.left_count; ++i) {
    if (half.vertices[i].midline) {
      head.twin[i] = i;
      continue;
    }
    HalfVertex v = half.vertices[i];
    v.position.x() = -v.position.x();
    v.uv.x() = 1 - v.uv.x();
    if (v.part == HeadPart::left_eyeball) v.part = HeadPart::right_eyeball;
    if (v.part == HeadPart::left_eye_socket) v.part = HeadPart::right_eye_socket;
    head.twin[i] = int(head.vertices.size());
    head.twin.push_back(i);
    head.vertices.push_back(v);
  }
  for (const Triangle& t : half.triangles)
    head.triangles.emplace_back(head.twin[t[0]], head.twin[t[2]], head.twin[t[1]]);
  return head;
}

double jaw_weight(const HalfVertex& v) {
  const double depth = smoothstep(2.45, 3, v.lip);
  const double corner = 0.5 * smoothstep(0.35, 1, v.along_lip);
  const Vec3d p(std::abs(v.position.x()), v.position.y(), v.position.z());
  switch (v.tissue) {
    case Tissue::lower_teeth:
      return 1;
    case Tissue::tongue:
      return mix(0.45, 1, smoothstep(40, 75, p.z()));
    case Tissue::upper_teeth:
    case Tissue::eyeball:
    case Tissue::ear:
    case Tissue::lid_inner:
      return 0;
    case Tissue::lip_inner:
      return mix(v.mouth_side > 0 ? corner : 1 - corner, 0.4, depth);
    case Tissue::skin:
      break;
  }
  if (v.part == HeadPart::torso) return 0;
  // Below a line from the corner of the mouth back to the condyle, over a band that widens backwards.
  const double azimuth = std::atan2(p.x(), p.z() - 10) * 180 / std::numbers::pi;
  const double back = std::clamp((azimuth - 15) / 70, 0.0, 1.0);
  const double line = mix(-34.6, 6, back), band = 5.5 + 32 * (1 - std::exp(-4 * back));
  const double inside = 1 - smoothstep(0.35, 1, v.along_lip);
  const double shift = v.mouth_side == 0 ? 0 : -v.mouth_side * band * inside * smoothstep(0.3, 1, v.lip);
  const double below = smoothstep(-band, band, line - p.y() + shift);
  const double lower_border = -54 - 0.36 * (p.z() - 24);
  const double throat = 1 - smoothstep(-2, 45, lower_border - p.y());
  const double nape = 1 - smoothstep(68, 108, azimuth);
  return below * throat * nape;
}

Vec3d bump_at(const Bump& bump, const Vec3d& point) {
  const auto weight = [&](const Vec3d& c) {
    return std::exp(-(point - c).cwiseQuotient(bump.radii).squaredNorm());
  };
  if (bump.centre.x() == 0) return bump.push * weight(bump.centre);
  const Vec3d flip(-1, 1, 1);
  return bump.push * weight(bump.centre) +
         bump.push.cwiseProduct(flip) * weight(bump.centre.cwiseProduct(flip));
}

Field mirrored(const WholeHead& head, const Field& left) {
  Field field(head.vertices.size());
  for (int i = 0; i < head.left_count; ++i) {
    field[i] = left[i];
    if (head.twin[i] == i)
      field[i].x() = 0;
    else
      field[head.twin[i]] = Vec3d(-left[i].x(), left[i].y(), left[i].z());
  }
  return field;
}

Field one_side(const WholeHead& head, const Field& symmetric, bool left) {
  Field field = symmetric;
  for (std::size_t i = 0; i < field.size(); ++i) {
    const double share = smoothstep(-7, 7, head.vertices[i].position.x());
    field[i] *= left ? share : 1 - share;
  }
  return field;
}

Field lid_field(const WholeHead& head, const EyeOpening& opening) {
  Field left(head.left_count, Vec3d::Zero());
  const auto open = eye_ring_positions(head.skin, kEyeOpen), other = eye_ring_positions(head.skin, opening);
  for (std::size_t r = 1; r < open.size(); ++r)
    for (std::size_t k = 0; k < open[r].size(); ++k)
      left[head.skin.eye_rings[r][k]] = other[r][k] - open[r][k];
  return mirrored(head, left);
}

}  // namespace likeness::builtin
