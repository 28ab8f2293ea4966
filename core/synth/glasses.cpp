// Shape of the glasses and the mirror images in their lenses.
#include "core/synth/glasses.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

constexpr int kAroundWire = 6, kOutline = 44;
constexpr float kWholeTurn = 2 * std::numbers::pi_v<float>;

// A tube along a line of points.
void add_tube(Glasses& g, const std::vector<Vec3f>& line, float radius, bool closed) {
  const int first = int(g.frame_vertices.size()), n = int(line.size());
  for (int i = 0; i < n; ++i) {
    const int before = closed ? (i + n - 1) % n : std::max(0, i - 1),
              after = closed ? (i + 1) % n : std::min(n - 1, i + 1);
    const Vec3f along = (line[std::size_t(after)] - line[std::size_t(before)]).normalized();
    const Vec3f side =
        (std::abs(along.z()) < 0.8f ? along.cross(Vec3f::UnitZ()) : along.cross(Vec3f::UnitY())).normalized();
    const Vec3f over = side.cross(along);
    for (int k = 0; k < kAroundWire; ++k) {
      const float angle = kWholeTurn * float(k) / kAroundWire;
      g.frame_vertices.push_back(line[std::size_t(i)] +
                                 radius * (std::cos(angle) * side + std::sin(angle) * over));
    }
  }
  for (int i = 0; i + (closed ? 0 : 1) < n; ++i) {
    for (int k = 0; k < kAroundWire; ++k) {
      const int a = first + i * kAroundWire + k, b = first + i * kAroundWire + (k + 1) % kAroundWire,
                c = first + ((i + 1) % n) * kAroundWire + k,
                d = first + ((i + 1) % n) * kAroundWire + (k + 1) % kAroundWire;
      g.frame_triangles.push_back(Triangle(a, b, c));
      g.frame_triangles.push_back(Triangle(b, d, c));
    }
  }
}

}  // namespace

Glasses make_glasses(const Scalp& skin, const std::array<Vec3f, 2>& eyes, const GlassesLook& look) {
  Glasses g;
  if (!look.worn) return g;
  const float unit = (eyes[0] - eyes[1]).norm() / 0.062f;
  const float half_w = (look.round ? 0.0228f : 0.0240f) * unit,
              half_h = (look.round ? 0.0222f : 0.0190f) * unit;
  const float square = look.round ? 1.0f : 0.62f;
  const float front = std::max(eyes[0].z(), eyes[1].z()) + 0.0275f * unit,
              height = 0.5f * (eyes[0].y() + eyes[1].y()) - 0.0045f * unit;
  const MeshScene scene(skin.vertices, skin.triangles);
  const auto bent = [&](float x, float y) {  // rims curve back towards the temples
    return Vec3f(x, y, front - 0.14f * std::max(0.0f, std::abs(x) - 0.018f));
  };
  for (std::size_t side = 0; side < 2; ++side) {
    const float sign = side == 0 ? 1.0f : -1.0f,
                cx = sign * (0.5f * (eyes[0].x() - eyes[1].x()) + 0.0022f * unit);
    std::vector<Vec3f> rim;
    for (int i = 0; i < kOutline; ++i) {
      const float a = kWholeTurn * float(i) / kOutline, c = std::cos(a), s = std::sin(a);
      const auto rounded = [&](float x) { return std::copysign(std::pow(std::abs(x), square), x); };
      rim.push_back(bent(cx + half_w * rounded(c), height + half_h * rounded(s) * (s < 0 ? 1.0f : 0.94f)));
    }
    add_tube(g, rim, look.thickness, true);
    g.lens_centre[side] = bent(cx, height);
    const int centre = int(g.lens_vertices.size());
    g.lens_vertices.push_back(g.lens_centre[side] + Vec3f(0, 0, 0.0012f));
    for (const Vec3f& p : rim) g.lens_vertices.push_back(p);
    for (int i = 0; i < kOutline; ++i)
      g.lens_triangles.push_back(Triangle(centre, centre + 1 + i, centre + 1 + (i + 1) % kOutline));
    // -- Side arm: from the rim's outer edge over the temple to the ear
    std::vector<Vec3f> arm;
    const Vec3f hinge = bent(cx + sign * half_w, height + 0.35f * half_h);
    for (int i = 0; i <= 14; ++i) {
      const float t = float(i) / 14;
      Vec3f p = hinge + t * Vec3f(sign * 0.018f, 0.004f, -hinge.z() - 0.004f);
      if (i > 0 && p.z() > 0.022f) {
        const auto hit = scene.intersect(Vec3f(sign * 0.2f, p.y(), p.z()), Vec3f(-sign, 0, 0), 0, 0.2f);
        if (hit) p.x() = sign * std::max(std::abs(p.x()), 0.2f - hit->distance + look.thickness);
      } else if (i > 0) {
        p.x() = sign * std::max(std::abs(p.x()), std::abs(arm.back().x()));
      }
      arm.push_back(p);
    }
    add_tube(g, arm, 1.05f * look.thickness, false);
  }
  // -- Bridge over the nose
  std::vector<Vec3f> bridge;
  const float inner = 0.5f * (eyes[0].x() - eyes[1].x()) + 0.0022f * unit - half_w;
  for (int i = 0; i <= 8; ++i) {
    const float t = float(i) / 4 - 1;
    bridge.push_back(bent(t * (inner + 0.001f), height + 0.30f * half_h + 0.0030f * (1 - t * t)) +
                     Vec3f(0, 0, 0.0015f * (1 - t * t)));
  }
  add_tube(g, bridge, 1.1f * look.thickness, false);
  return g;
}

Vec3f shade_lens(const Glasses& glasses, const LightRig& rig, const Vec3f& up, const Vec3f& position,
                 const Vec3f& to_eye) {
  const Vec3f from_centre = position - glasses.lens_centre[position.x() > 0 ? 0 : 1];
  const float turned = position.x() > 0 ? 0.10f : -0.10f;
  Vec3f normal = Vec3f(turned + from_centre.x() / 0.12f, from_centre.y() / 0.12f - 0.10f, 1).normalized();
  if (normal.dot(to_eye) < 0) normal = -normal;
  constexpr float f0 = 0.06f;
  Vec3f mirrored = Vec3f::Zero();
  for (const AreaLight* light : {&rig.key, &rig.fill, &rig.rim})
    mirrored += glossy(*light, position, normal, to_eye, 0.12f, f0);
  const Vec3f away = 2 * normal.dot(to_eye) * normal - to_eye;
  // A coated lens: the reflection of a large light in a bare one would hide the eye.
  return (0.22f * mirrored).cwiseMin(0.6f) +
         0.5f * fresnel(f0, normal.dot(to_eye)) * rig.glow(Vec3f(0, away.dot(up), 0));
}

}  // namespace likeness
