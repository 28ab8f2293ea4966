// A guide is a walk: along the skull, then free under its weight, pushed out of skin and cloth at every step.
#include "core/synth/loose_hair.h"

#include <algorithm>
#include <cmath>

#include "core/synth/noise.h"

namespace likeness {
namespace {

constexpr int kLoosePoints = 30;
constexpr float kStand = 0.140f;  // m, how far out of the head's axis loose hair stands at the jaw
constexpr float kReach = 0.04f;   // m, depth below a surface from which points are brought back

MeshScene surface_of(const Scalp& skin, const Cloth& cloth) {
  std::vector<Vec3f> vertices = skin.vertices;
  std::vector<Triangle> triangles = skin.triangles;
  const int first = int(vertices.size());
  vertices.insert(vertices.end(), cloth.vertices.begin(), cloth.vertices.end());
  for (const Triangle& t : cloth.triangles) triangles.push_back(t + Triangle::Constant(first));
  return MeshScene(std::move(vertices), std::move(triangles));
}

Vec3f without(const Vec3f& v, const Vec3f& n) { return v - v.dot(n) * n; }

// How a lock falls, the same for its neighbours.
struct Fall {
  bool before = false;  // in front of the shoulder, not behind it
  float azimuth = 0;    // it falls at, from the front, rad
  float stand = 0;      // m, out of the head's axis
  float tip_y = 0;
  float wave = 0;  // phase
};

Fall fall_of(const Vec3f& root, const HeadProportions& a, std::uint32_t seed) {
  const float azimuth = std::atan2(std::abs(root.x()), root.z() + 0.01f);
  const float grouped = noise(root * 28.0f, 311);  // locks fall together
  Fall fall;
  fall.before = azimuth < 1.55f + 0.55f * grouped;
  // Beside the face, or fanned over the back.
  fall.azimuth =
      fall.before ? 1.16f + 0.34f * hash_unit(seed + 8) : std::max(1.50f, azimuth + 0.25f * grouped);
  const float inside = hash_unit(seed + 7);
  fall.stand = kStand * a.unit * (0.80f + 0.22f * std::sqrt(inside) + 0.05f * grouped);
  fall.tip_y = a.chin_y - (0.135f + 0.045f * hash_unit(seed + 5) + 0.02f * grouped) * a.unit;
  fall.wave = 6.0f * grouped + 0.8f * hash_unit(seed + 9);
  return fall;
}

// The way over the skull: away from the parting, down and back.
Vec3f combed(const Vec3f& at, const Vec3f& n, float side, std::uint32_t seed) {
  const float front = smoothstep(0.0f, 0.07f, at.z()), high = smoothstep(0.25f, 0.85f, n.y());
  Vec3f d = mix(Vec3f(0, -1, -0.25f - 0.8f * front), Vec3f(side, -0.05f, -0.15f - 0.6f * front), high);
  d += 0.12f * Vec3f(noise(at * 40.0f, seed & 0xffu), noise(at * 40.0f, 1), noise(at * 40.0f, 2));
  return without(d, n).normalized();
}

// Free fall from a point beside the head: out to where the lock stands, and round to its azimuth.
Vec3f falling(const Vec3f& at, const Fall& fall) {
  constexpr float kWithin = 0.06f;  // m of the fall, of what is missing
  float azimuth = std::atan2(std::abs(at.x()), at.z() + 0.01f);
  azimuth += std::clamp(fall.azimuth - azimuth, -0.20f, 0.30f);
  const Vec3f out(std::copysign(std::sin(azimuth), at.x()), 0, std::cos(azimuth));
  const Vec3f missing = fall.stand * out - Vec3f(at.x(), 0, at.z() + 0.01f);
  const float steep = missing.norm() / kWithin;
  return (Vec3f(0, -1, 0) + missing / kWithin * std::min(1.0f, 0.65f / std::max(steep, 1e-3f))).normalized();
}

// The share of the head's motion: all of it on the skull, less and less on the way to where the lock comes to
// lie, none from there.
void share_motion(HairGuide& guide, int hangs_from, int lies_from) {
  const int count = guide.count();
  const bool lies = lies_from < count;
  const int end = lies ? lies_from : count - 1;
  guide.follow.resize(std::size_t(count));
  for (int k = 0; k < count; ++k) {
    const float t = end > hangs_from ? float(k - hangs_from) / float(end - hangs_from) : float(k >= end);
    guide.follow[std::size_t(k)] =
        1 - (lies ? 1.0f : 0.6f) * smoothstep(0.0f, 1.0f, std::clamp(t, 0.0f, 1.0f));
  }
}

}  // namespace

Drape::Drape(const Scalp& skin, const Cloth& cloth)
    : first_cloth_(int(skin.triangles.size())), scene_(surface_of(skin, cloth)) {}

int Drape::lift(Vec3f& point, float distance, Vec3f& normal) const {
  const auto near = scene_.closest(point, kReach);
  if (!near) return -1;
  const Triangle& t = scene_.triangles()[std::size_t(near->triangle)];
  const auto& v = scene_.vertices();
  const Vec3f& a = v[std::size_t(t[0])];
  normal = (v[std::size_t(t[1])] - a).cross(v[std::size_t(t[2])] - a).normalized();
  if ((point - near->position).dot(normal) >= distance) return -1;
  point = near->position + distance * normal;
  return near->triangle;
}

HairGuide walk_loose(const Skull& skull, const Drape& drape, const Vec3f& root, const Vec3f& normal,
                     const HeadProportions& a, std::uint32_t seed) {
  HairGuide guide(kLoosePoints);
  guide.root = root;
  const float side = root.x() > 0.010f * a.unit ? 1.0f : -1.0f;
  const float top = smoothstep(0.1f, 0.75f, normal.y());
  const Fall fall = fall_of(root, a, seed);
  const float stride =
      (std::max(0.03f, root.y() - fall.tip_y) + 0.05f + 0.09f * top * a.unit) / (kLoosePoints - 1);
  const float full = (0.010f + 0.012f * hash_unit(seed + 6)) * a.unit;
  const float above_cloth = 0.003f + 0.014f * hash_unit(seed + 4);
  Vec3f at = root, n = normal;
  int hangs_from = kLoosePoints, lies_from = kLoosePoints;
  for (int k = 0; k < kLoosePoints; ++k) {
    const std::size_t i = std::size_t(k);
    if (hangs_from > k) {
      guide.lift[i] = full * smoothstep(0.0f, 0.2f, float(k) / (kLoosePoints - 1));
      guide.normals[i] = n;
      guide.points[i] = at + guide.lift[i] * n;
      if (k > 0 && at.y() < a.brow_y + 0.045f * a.unit && n.y() < 0.2f) {
        hangs_from = k;
        at = guide.points[i];
        continue;
      }
      skull.settle(at + stride * combed(at, n, side, seed), at, n);
      continue;
    }
    const Vec3f fallen = falling(at, fall);
    Vec3f d = fallen;
    if (lies_from <= k) {  // along the cloth: down, forward before the shoulder and back behind it
      d = without(Vec3f(0, -1, fall.before ? 0.35f : -0.35f), n).normalized();
    }
    Vec3f next = at + stride * d, surface;
    const int touched =
        drape.lift(next, lies_from <= k ? above_cloth : std::max(0.006f, above_cloth), surface);
    if (touched >= 0 && drape.is_cloth(touched)) {
      lies_from = std::min(lies_from, k);
      n = surface;
    } else {
      n = Vec3f(at.x(), 0, at.z() + 0.01f).normalized();
    }
    at = next;
    const float s = float(k) / (kLoosePoints - 1);
    const Vec3f across = n.cross(Vec3f::UnitY()).normalized();
    const float wave = 0.0045f * smoothstep(0.25f, 0.8f, s);
    guide.normals[i] = n;
    guide.points[i] =
        at + wave * (std::sin(fall.wave + 13 * s) * across + std::cos(fall.wave + 11 * s) * 0.5f * n);
  }
  share_motion(guide, hangs_from, lies_from);
  return guide;
}

}  // namespace likeness
