// Guides are traced over the skull along a combing field; strands follow their guide, spread at the root and
// gathered towards the tip; the light a lock receives is traced once, on the guides.
#include "core/synth/hair.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/base/parallel.h"
#include "core/scene/mesh_scene.h"
#include "core/synth/hair_guide.h"
#include "core/synth/loose_hair.h"
#include "core/synth/noise.h"

namespace likeness {
namespace {

constexpr int kShortPoints = 9, kLongPoints = 14, kBeardPoints = 5;  // of a strand

HeadProportions proportions_of(const std::array<Vec3f, kLandmarkCount>& l) {
  return {0.5f * (l[19].y() + l[24].y()), (l[16].x() - l[0].x()) / 0.147f, l[8].y()};
}

// Height of the hairline over the brows at an azimuth from the front (0) to the back (pi).
float hairline_height(float azimuth) {
  constexpr std::array<std::array<float, 2>, 11> line = {{{0.0f, 0.045f},
                                                          {0.40f, 0.046f},
                                                          {0.75f, 0.047f},
                                                          {0.98f, 0.030f},
                                                          {1.12f, 0.012f},
                                                          {1.24f, -0.022f},
                                                          {1.36f, -0.030f},
                                                          {1.46f, 0.012f},
                                                          {1.90f, 0.006f},
                                                          {2.15f, -0.045f},
                                                          {3.15f, -0.095f}}};
  for (std::size_t i = 1; i < line.size(); ++i) {
    if (azimuth <= line[i][0]) {
      const float t = (azimuth - line[i - 1][0]) / (line[i][0] - line[i - 1][0]);
      return line[i - 1][1] + t * (line[i][1] - line[i - 1][1]);
    }
  }
  return line.back()[1];
}

// The combing direction at a point: from a parting on the subject's left over the top, back at the sides.
Vec3f combing(const Vec3f& root, const Vec3f& normal, const HeadProportions& a, const HairLook& look,
              std::uint32_t seed) {
  const float top = smoothstep(0.25f, 0.75f, normal.y() + 0.35f * std::max(0.0f, normal.z()));
  const float across = smoothstep(-0.012f, 0.012f, root.x() - 0.030f * a.unit);
  const Vec3f over = mix(Vec3f(-0.62f, 0.20f, -0.60f), Vec3f(0.75f, -0.1f, -0.55f), across);
  const Vec3f down(0.0f, -0.85f, -0.52f);
  Vec3f d = mix(down, over, top);
  const float wild = 0.22f + 1.3f * look.curl, fine = 45.0f + 300.0f * look.curl;
  d += wild * Vec3f(noise(root * fine, seed), noise(root * fine, seed + 1), noise(root * fine, seed + 2));
  return (d - d.dot(normal) * normal).normalized();
}

HairGuide walk_short(const Skull& skull, const Vec3f& root, const Vec3f& normal, const HeadProportions& a,
                     const HairLook& look, std::uint32_t seed) {
  HairGuide guide(kShortPoints);
  constexpr int kPoints = kShortPoints;
  guide.root = root;
  const float top = smoothstep(0.1f, 0.75f, normal.y() + 0.25f * normal.z());
  const float front = smoothstep(0.03f, 0.085f, root.z()) * top;
  const float height = (root.y() - a.brow_y) / a.unit;
  const float side = smoothstep(-0.08f, 0.05f, height);
  float length = (0.013f + 0.013f * side + 0.037f * top) * a.unit * (0.85f + 0.3f * hash_unit(seed + 5));
  float full = (0.0035f + 0.0035f * side + 0.010f * top + 0.010f * front) * a.unit;
  if (look.cut == HairCut::cropped) {
    length = 0.011f * a.unit * (0.7f + 0.6f * hash_unit(seed + 5));
    full = (0.0030f + 0.0035f * side + 0.0035f * top) * a.unit;
  } else if (look.cut == HairCut::receding) {
    length *= 0.62f, full *= 0.5f;
  }
  Vec3f at = root, n = normal;
  for (int k = 0; k < kPoints; ++k) {
    const float s = float(k) / float(kPoints - 1);
    guide.lift[std::size_t(k)] = full * std::pow(s, 0.55f) * (1 - 0.38f * s * s);
    guide.normals[std::size_t(k)] = n;
    guide.points[std::size_t(k)] = at + guide.lift[std::size_t(k)] * n;
    // The front rises before it falls: its first steps along the skull are shorter.
    const float stride =
        length / float(kPoints - 1) * (front > 0 ? mix(1.0f, 0.35f + 0.9f * s, front) : 1.0f);
    skull.settle(at + stride * combing(at, n, a, look, seed & 0xffu), at, n);
  }
  return guide;
}

// Away from a parting and down over the skull until it turns under, then straight down past ears, jaw and
// neck.
HairGuide walk_long(const Skull& skull, const Vec3f& root, const Vec3f& normal, const HeadProportions& a,
                    const HairLook& look, std::uint32_t seed) {
  HairGuide guide(kLongPoints);
  guide.root = root;
  const bool bob = look.cut == HairCut::bob;
  const float side = root.x() > 0.010f * a.unit ? 1.0f : -1.0f;
  const float top = smoothstep(0.1f, 0.75f, normal.y());
  const float tip_y = a.chin_y + (bob ? 0.020f : -0.082f) * a.unit + 0.022f * (hash_unit(seed + 5) - 0.5f);
  const float stride =
      (std::max(0.03f, root.y() - tip_y) + (0.075f + 0.02f * hash_unit(seed + 6)) * top * a.unit) /
      float(kLongPoints - 1);
  const float full = (0.007f + 0.011f * hash_unit(seed + 7)) * a.unit * (bob ? 1.25f : 1.0f);
  const float fall_azimuth = 1.12f + 0.26f * hash_unit(seed + 8);
  Vec3f at = root, n = normal;
  bool hanging = false;
  for (int k = 0; k < kLongPoints; ++k) {
    const std::size_t i = std::size_t(k);
    const float s = float(k) / float(kLongPoints - 1);
    guide.lift[i] = hanging ? 0 : full * smoothstep(0.0f, 0.25f, s);
    guide.normals[i] = n;
    guide.points[i] = at + guide.lift[i] * n;
    if (!hanging && at.y() < a.brow_y + 0.035f * a.unit && n.y() < 0.12f && k > 0) {
      hanging = true;
      at = guide.points[i];
    }
    if (!hanging) {
      const float front = smoothstep(0.0f, 0.07f, at.z());
      const float high = smoothstep(0.25f, 0.85f, n.y());
      Vec3f d = mix(Vec3f(0, -1, -0.30f - 1.1f * front), Vec3f(side, -0.05f, -0.20f - 0.75f * front), high);
      d += 0.12f * Vec3f(noise(at * 40.0f, seed & 0xffu), noise(at * 40.0f, 1), noise(at * 40.0f, 2));
      d = (d - d.dot(n) * n).normalized();
      skull.settle(at + stride * d, at, n);
      continue;
    }
    if (at.y() < tip_y) continue;
    Vec3f next = at - Vec3f(0, stride, 0);
    float azimuth = std::atan2(std::abs(next.x()), next.z() + 0.01f),
          radius = std::hypot(next.x(), next.z() + 0.01f);
    if (azimuth < fall_azimuth) azimuth += std::min(0.20f, fall_azimuth - azimuth);
    const Vec3f out(std::copysign(std::sin(azimuth), at.x()), 0, std::cos(azimuth));
    const Vec3f axis(0, next.y(), -0.01f);
    const auto hit = skull.scene.intersect(axis + 0.25f * out, -out, 0, 0.25f);
    const float skin = hit ? 0.25f - hit->distance : 0;
    radius = std::max(radius * (bob && next.y() < a.chin_y + 0.05f ? 0.955f : 0.992f),
                      skin + 0.35f * full + 0.004f);
    at = axis + radius * out;
    n = out;
  }
  return guide;
}

// How a strand differs from its guide.
struct Strand {
  Vec3f root;
  float layer = 1;  // 0 lies on the skin, 1 is as far out as the guide
  float tone = 1, white = 0, width = 0.0007f;
  float wave = 1;  // size of its own bends, about 1 mm
};

void add_strand(HairMesh& mesh, const HairGuide& guide, const Strand& strand, RandomStream& random) {
  const int first = int(mesh.vertices.size()), count = guide.count();
  const Vec3f spread = strand.root - guide.root;
  const bool loose = !guide.follow.empty();
  const float phase = random.between(0, 6.28f), wave = strand.wave * random.between(0.0003f, 0.0016f),
              gather = loose ? random.between(-1.2f, 0.5f) : random.between(0.3f, 0.75f);
  const float shorter = random.between(0.72f, 1.0f), tilt = random.between(-1.1f, 1.1f);
  std::vector<Vec3f> line(static_cast<std::size_t>(count));
  std::vector<float> follow(loose ? line.size() : 0);
  for (int k = 0; k < count; ++k) {
    const float s = shorter * float(k) / float(count - 1), f = s * float(count - 1);
    const std::size_t i = std::size_t(std::min(int(f), count - 2));
    const float t = f - float(i);
    const Vec3f n = mix(guide.normals[i], guide.normals[i + 1], t);
    const float lift = mix(guide.lift[i], guide.lift[i + 1], t);
    const Vec3f side = n.cross(guide.points[i + 1] - guide.points[i]).normalized();
    if (loose) follow[std::size_t(k)] = mix(guide.follow[i], guide.follow[i + 1], t);
    line[std::size_t(k)] = mix(guide.points[i], guide.points[i + 1], t) + spread * (1 - gather * s) -
                           n * (1 - strand.layer) * lift + side * wave * s * std::sin(phase + 5 * s) +
                           n * 0.6f * wave * s * std::cos(phase + 4 * s);
  }
  for (int k = 0; k < count; ++k) {
    const std::size_t i = std::size_t(k), before = i == 0 ? 0 : i - 1,
                      after = std::min(i + 1, std::size_t(count - 1));
    const float s = shorter * float(k) / float(count - 1);
    const Vec3f tangent = (line[after] - line[before]).normalized();
    const Vec3f n = guide.normals[i];
    const Vec3f flat = tangent.cross(n).normalized();
    const Vec3f wide =
        (std::cos(tilt) * flat + std::sin(tilt) * n) * (0.5f * strand.width * (1 - 0.75f * s * s * s));
    for (const float sign : {-1.0f, 1.0f}) {
      mesh.vertices.push_back(line[i] + sign * wide);
      mesh.tangents.push_back(tangent);
      mesh.outward.push_back(n);
      mesh.tone.push_back(strand.tone);
      mesh.white.push_back(strand.white);
      mesh.depth_light.push_back(std::clamp(0.25f + 0.75f * strand.layer * (0.45f + 0.55f * s), 0.0f, 1.0f));
      mesh.open.push_back(guide.open[i]);
      if (guide.anchor >= 0) mesh.anchor.push_back(guide.anchor);
      if (loose) mesh.follow.push_back(follow[i]);
    }
    if (k + 1 < count) {
      const int q = first + 2 * k;
      mesh.triangles.push_back(Triangle(q, q + 1, q + 2));
      mesh.triangles.push_back(Triangle(q + 1, q + 3, q + 2));
    }
  }
}

// Freedom of the guides' points: rays against the skull, and how deep under the hair's hull the point is.
void light_guides(std::vector<HairGuide>& guides, const MeshScene& skull) {
  constexpr int rays = 32;
  parallel_for(guides.size(), [&](std::size_t g) {
    HairGuide& guide = guides[g];
    for (std::size_t k = 0; k < guide.points.size(); ++k) {
      float mean = 0;
      Vec3f slope = Vec3f::Zero();
      for (int i = 0; i < rays; ++i) {
        const float z = 1 - (2 * float(i) + 1) / rays, r = std::sqrt(1 - z * z), angle = 2.399963f * float(i);
        const Vec3f d(r * std::cos(angle), r * std::sin(angle), z);
        if (skull.occluded(guide.points[k], d, 0.0008f, 0.3f)) continue;
        mean += 1;
        slope += d;
      }
      guide.open[k][0] = mean / rays;
      guide.open[k].tail<3>() = 3.0f * slope / rays;
    }
  });
}

// Points sampled uniformly over some triangles of the skin.
class Sower {
 public:
  Sower(const Scalp& skin, const std::function<bool(const Vec3f& middle, const Vec3f& normal)>& wanted)
      : skin_(skin), normals_(skin.vertices.size(), Vec3f::Zero()) {
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
      const Triangle& f = skin.triangles[t];
      const Vec3f &p = skin.vertices[std::size_t(f[0])], &q = skin.vertices[std::size_t(f[1])],
                  &r = skin.vertices[std::size_t(f[2])];
      const Vec3f n = 0.5f * (q - p).cross(r - p);
      for (int k = 0; k < 3; ++k) normals_[std::size_t(f[k])] += n;
      if (!wanted((p + q + r) / 3, n.normalized())) continue;
      area_ += n.norm();
      reach_.push_back(area_);
      chosen_.push_back(int(t));
    }
    for (Vec3f& n : normals_) n.normalize();
  }
  bool empty() const { return chosen_.empty(); }
  double area() const { return area_; }
  const std::vector<Vec3f>& normals() const { return normals_; }

  struct Seed {
    Vec3f position, normal;
    int triangle = 0;
  };
  Seed draw(RandomStream& random) const {
    const double pick = area_ * random.unit();
    const std::size_t i = std::size_t(std::lower_bound(reach_.begin(), reach_.end(), pick) - reach_.begin());
    Seed seed;
    seed.triangle = chosen_[std::min(i, chosen_.size() - 1)];
    const Triangle& t = skin_.triangles[std::size_t(seed.triangle)];
    float u = random.unit(), v = random.unit();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto blended = [&](const std::vector<Vec3f>& values) -> Vec3f {
      return values[std::size_t(t[0])] * (1 - u - v) + values[std::size_t(t[1])] * u +
             values[std::size_t(t[2])] * v;
    };
    seed.normal = blended(normals_).normalized();
    seed.position = blended(skin_.vertices);
    return seed;
  }

 private:
  const Scalp& skin_;
  std::vector<Vec3f> normals_;
  std::vector<double> reach_;  // running area of the chosen triangles
  std::vector<int> chosen_;
  double area_ = 0;
};

// Strands round each guide.
void fill_locks(HairMesh& mesh, const std::vector<HairGuide>& guides, double area, const HairOptions& options,
                float wave, RandomStream& random) {
  const float lock_radius = 1.25f * std::sqrt(float(area) / (3.14159f * float(guides.size())));
  for (const HairGuide& guide : guides) {
    const float lock_tone = random.between(0.78f, 1.22f);
    const Vec3f n = guide.normals[0];
    const Vec3f e = (std::abs(n.y()) < 0.8f ? n.cross(Vec3f::UnitY()) : n.cross(Vec3f::UnitX())).normalized(),
                f = n.cross(e);
    for (int k = 0; k < options.strands_per_lock; ++k) {
      const float r = lock_radius * std::sqrt(random.unit()), angle = random.between(0, 6.28318f);
      Strand strand;
      strand.root = guide.root + r * (std::cos(angle) * e + std::sin(angle) * f);
      strand.layer = std::pow(random.unit(), 0.6f) * (random.unit() < 0.02f ? 1.35f : 1.0f);
      strand.tone = lock_tone * random.between(0.7f, 1.3f);
      strand.width = options.width_m;
      strand.wave = wave;
      if (options.look.grey > 0) strand.white = random.unit() < options.look.grey ? 1.0f : 0.0f;
      add_strand(mesh, guide, strand, random);
    }
  }
}

}  // namespace

float inside_hairline(const std::array<Vec3f, kLandmarkCount>& landmarks, HairCut cut, const Vec3f& p) {
  const HeadProportions a = proportions_of(landmarks);
  const float azimuth = std::atan2(std::abs(p.x()), p.z() - 0.002f);
  const float ragged = 0.003f * noise(p * 130.0f, 900) + 0.003f * noise(p * 45.0f, 901);
  float line = hairline_height(azimuth);
  if (cut == HairCut::receding) {
    line += 0.018f * (1 - smoothstep(0.9f, 1.15f, azimuth)) +
            0.022f * std::exp(-std::pow((azimuth - 0.55f) / 0.25f, 2.0f));
  }
  return p.y() - a.brow_y - a.unit * line + ragged;
}

bool hangs(HairCut cut) {
  return cut == HairCut::shoulder_long || cut == HairCut::bob || cut == HairCut::loose;
}

HairMesh grow_hair(const Scalp& skin, const Cloth& cloth, const HairOptions& options) {
  const HeadProportions a = proportions_of(skin.landmarks);
  const MeshScene scene(skin.vertices, skin.triangles);
  const HairLook& look = options.look;
  const Sower sower(skin, [&](const Vec3f& middle, const Vec3f& n) {
    // An ear's own skin faces in all directions close to its plane; hair does not grow there.
    const bool ear = std::abs(middle.x()) > 0.070f * a.unit && middle.y() < a.brow_y + 0.004f &&
                     middle.y() > a.brow_y - 0.08f && std::abs(middle.z() + 0.005f) < 0.045f &&
                     std::abs(n.x()) < 0.75f;
    return !ear && inside_hairline(skin.landmarks, look.cut, middle) >= 0;
  });
  HairMesh mesh;
  if (sower.empty()) return mesh;
  RandomStream random{hash_u32(options.seed + 555)};
  std::vector<Sower::Seed> roots;
  for (int i = 0; i < options.locks; ++i) roots.push_back(sower.draw(random));
  const Skull skull{scene, sower.normals()};
  std::optional<Drape> drape;
  if (look.cut == HairCut::loose) drape.emplace(skin, cloth);
  std::vector<HairGuide> guides(roots.size(), HairGuide(0));
  parallel_for(roots.size(), [&](std::size_t i) {
    const std::uint32_t seed = hash_u32(options.seed * 31 + std::uint32_t(i)) & 0xffffff00u;
    guides[i] = drape             ? walk_loose(skull, *drape, roots[i].position, roots[i].normal, a, seed)
                : hangs(look.cut) ? walk_long(skull, roots[i].position, roots[i].normal, a, look, seed)
                                  : walk_short(skull, roots[i].position, roots[i].normal, a, look, seed);
  });
  light_guides(guides, drape ? drape->scene() : scene);
  fill_locks(mesh, guides, sower.area(), options, hangs(look.cut) ? 1.6f : 1.0f + 0.8f * look.curl, random);
  return mesh;
}

HairMesh grow_beard(const Scalp& skin, const std::function<float(const Vec3f&)>& share,
                    const HairOptions& options) {
  const MeshScene scene(skin.vertices, skin.triangles);
  const Sower sower(skin, [&](const Vec3f& middle, const Vec3f&) { return share(middle) > 0.12f; });
  HairMesh mesh;
  if (sower.empty()) return mesh;
  RandomStream random{hash_u32(options.seed + 777)};
  const Vec3f chin = skin.landmarks[8], mouth = 0.5f * (skin.landmarks[62] + skin.landmarks[66]);
  std::vector<HairGuide> guides;
  for (int i = 0; i < options.locks; ++i) {
    const Sower::Seed seed = sower.draw(random);
    const float here = share(seed.position), bend = random.between(0.75f, 1.25f);
    if (random.unit() > 1.2f * here) continue;
    const bool moustache = seed.position.y() > mouth.y() && std::abs(seed.position.x()) < 0.032f;
    const float low = smoothstep(mouth.y() + 0.02f, chin.y(), seed.position.y());
    const float length = options.look.beard * (moustache ? 0.55f : 0.45f + 0.6f * low) * (0.5f + 0.5f * here);
    Vec3f along(seed.position.x() * (moustache ? 22.0f : 4.0f), -1.0f, moustache ? 0.1f : 0.15f * low);
    const float z = random.unit() - 0.5f, y = random.unit() - 0.5f, x = random.unit() - 0.5f;
    along += 0.30f * Vec3f(x, y, z);
    along = (along - along.dot(seed.normal) * seed.normal).normalized();
    HairGuide guide(kBeardPoints);
    guide.root = seed.position;
    guide.anchor = seed.triangle;
    for (int k = 0; k < kBeardPoints; ++k) {
      const std::size_t at = std::size_t(k);
      const float s = float(k) / float(kBeardPoints - 1);
      guide.lift[at] = length * (0.50f * s + 0.12f * s * (1 - s)) * bend;
      guide.normals[at] = seed.normal;
      guide.points[at] = seed.position + length * 0.85f * s * along + guide.lift[at] * seed.normal;
    }
    guides.push_back(std::move(guide));
  }
  if (guides.empty()) return mesh;
  light_guides(guides, scene);
  fill_locks(mesh, guides, sower.area(), options, 0.8f, random);
  return mesh;
}

Vec3f shade_hair(const LightRig& rig, const Vec3f& up, const HairPoint& point, const Vec3f& to_eye) {
  const Vec3f& base = point.colour;
  const Vec3f& t = point.tangent;
  const auto open_to = [&](const Vec3f& d) {
    return std::clamp(point.open[0] + point.open.tail<3>().dot(d), 0.0f, 1.0f);
  };
  Vec3f radiance = Vec3f::Zero();
  for (const AreaLight* light : {&rig.key, &rig.fill, &rig.rim}) {
    const Vec3f to = light->centre - point.position;
    const float distance = to.norm();
    const Vec3f d = to / distance, out = light->half_u.cross(light->half_v);
    const float facing = -d.dot(out);  // half-areas: area is four times this
    if (facing <= 0) continue;
    const Vec3f power = light->radiance * (4 * facing / (std::numbers::pi_v<float> * distance * distance));
    const float open = open_to(d) * point.depth_light;
    const float hull = std::clamp((point.outward.dot(d) + 0.45f) / 1.45f, 0.0f, 1.0f);
    const float along = t.dot(d), sine = std::sqrt(std::max(0.0f, 1 - along * along));
    radiance += (power.array() * base.array() * (open * hull * (0.35f + 0.65f * sine))).matrix();
    // Two highlights: white from the surface, shifted to the root; coloured from within, shifted to the tip.
    const Vec3f half = (d + to_eye).normalized();
    const float th = t.dot(half);
    const float white = std::exp(-std::pow((th + 0.09f) / 0.13f, 2.0f)),
                within = std::exp(-std::pow((th - 0.14f) / 0.26f, 2.0f));
    radiance += power.cwiseProduct(Vec3f::Constant(0.030f * white) + 0.55f * within * base) *
                (open * hull * hull * sine);
  }
  const float sky = std::clamp(point.open[0] * 1.4f, 0.0f, 1.0f) * point.depth_light;
  const Vec3f glow = rig.glow(Vec3f(0, point.outward.dot(up), 0));
  radiance += 0.85f * sky * base.cwiseProduct(glow);
  return radiance;
}

}  // namespace likeness
