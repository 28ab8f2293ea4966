// Guides are walked over the skull along a combing field; strands follow their guide, spread at the root and
// gathered towards the tip; the light a lock receives is traced once, on the guides.
#include "core/synth/hair.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/parallel.h"
#include "core/scene/mesh_scene.h"
#include "core/synth/noise.h"

namespace likeness {
namespace {

constexpr int kPoints = 9;  // of a strand

struct Guide {
  std::array<Vec3f, kPoints> points, normals;
  std::array<float, kPoints> lift;
  std::array<Eigen::Vector4f, kPoints> open;
  Vec3f root;
};

struct Proportions {
  float brow_y, unit;  // unit: 1 for a head as wide as usual at the temples
};

Proportions proportions_of(const std::array<Vec3f, kLandmarkCount>& l) {
  return {0.5f * (l[19].y() + l[24].y()), (l[16].x() - l[0].x()) / 0.147f};
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

// Where the hair wants to go at a point: from a parting on the subject's left over the top, back at the
// sides.
Vec3f combing(const Vec3f& root, const Vec3f& normal, const Proportions& a, std::uint32_t seed) {
  const float top = smoothstep(0.25f, 0.75f, normal.y() + 0.35f * std::max(0.0f, normal.z()));
  const float across = smoothstep(-0.012f, 0.012f, root.x() - 0.030f * a.unit);
  const Vec3f over = mix(Vec3f(-0.62f, 0.20f, -0.60f), Vec3f(0.75f, -0.1f, -0.55f), across);
  const Vec3f down(0.0f, -0.85f, -0.52f);
  Vec3f d = mix(down, over, top);
  d += 0.22f * Vec3f(noise(root * 45.0f, seed), noise(root * 45.0f, seed + 1), noise(root * 45.0f, seed + 2));
  return (d - d.dot(normal) * normal).normalized();
}

Guide walk(const MeshScene& skull, const std::vector<Vec3f>& normals, const Vec3f& root, const Vec3f& normal,
           const Proportions& a, std::uint32_t seed) {
  Guide guide;
  guide.root = root;
  const float top = smoothstep(0.1f, 0.75f, normal.y() + 0.25f * normal.z());
  const float front = smoothstep(0.03f, 0.085f, root.z()) * top;
  const float height = (root.y() - a.brow_y) / a.unit;
  const float side = smoothstep(-0.08f, 0.05f, height);
  const float length =
      (0.013f + 0.013f * side + 0.037f * top) * a.unit * (0.85f + 0.3f * hash_unit(seed + 5));
  const float full = (0.0035f + 0.0035f * side + 0.010f * top + 0.010f * front) * a.unit;
  Vec3f at = root, n = normal;
  for (int k = 0; k < kPoints; ++k) {
    const float s = float(k) / float(kPoints - 1);
    guide.lift[std::size_t(k)] = full * std::pow(s, 0.55f) * (1 - 0.38f * s * s);
    guide.normals[std::size_t(k)] = n;
    guide.points[std::size_t(k)] = at + guide.lift[std::size_t(k)] * n;
    // The front rises before it falls: its first steps along the skull are shorter.
    const float stride =
        length / float(kPoints - 1) * (front > 0 ? mix(1.0f, 0.35f + 0.9f * s, front) : 1.0f);
    const auto next = skull.closest(at + stride * combing(at, n, a, seed & 0xffu), 0.05f);
    if (!next) continue;
    const Triangle& t = skull.triangles()[std::size_t(next->triangle)];
    at = next->position;
    n = (normals[std::size_t(t[0])] * next->barycentric[0] +
         normals[std::size_t(t[1])] * next->barycentric[1] +
         normals[std::size_t(t[2])] * next->barycentric[2])
            .normalized();
  }
  return guide;
}

void add_strand(HairMesh& mesh, const Guide& guide, const Vec3f& root, float layer, float tone, float width,
                RandomStream& random) {
  const int first = int(mesh.vertices.size());
  const Vec3f spread = root - guide.root;
  const float phase = random.between(0, 6.28f), wave = random.between(0.0003f, 0.0016f),
              gather = random.between(0.3f, 0.75f);
  const float shorter = random.between(0.72f, 1.0f), tilt = random.between(-1.1f, 1.1f);
  std::array<Vec3f, kPoints> line;
  for (int k = 0; k < kPoints; ++k) {
    const float s = shorter * float(k) / float(kPoints - 1), f = s * float(kPoints - 1);
    const std::size_t i = std::size_t(std::min(int(f), kPoints - 2));
    const float t = f - float(i);
    const Vec3f n = mix(guide.normals[i], guide.normals[i + 1], t);
    const float lift = mix(guide.lift[i], guide.lift[i + 1], t);
    const Vec3f side = n.cross(guide.points[i + 1] - guide.points[i]).normalized();
    line[std::size_t(k)] = mix(guide.points[i], guide.points[i + 1], t) + spread * (1 - gather * s) -
                           n * (1 - layer) * lift + side * wave * s * std::sin(phase + 5 * s) +
                           n * 0.6f * wave * s * std::cos(phase + 4 * s);
  }
  for (int k = 0; k < kPoints; ++k) {
    const std::size_t i = std::size_t(k), before = i == 0 ? 0 : i - 1,
                      after = std::min(i + 1, std::size_t(kPoints - 1));
    const float s = shorter * float(k) / float(kPoints - 1);
    const Vec3f tangent = (line[after] - line[before]).normalized();
    const Vec3f n = guide.normals[i];
    const Vec3f flat = tangent.cross(n).normalized();
    const Vec3f wide =
        (std::cos(tilt) * flat + std::sin(tilt) * n) * (0.5f * width * (1 - 0.75f * s * s * s));
    for (const float sign : {-1.0f, 1.0f}) {
      mesh.vertices.push_back(line[i] + sign * wide);
      mesh.tangents.push_back(tangent);
      mesh.outward.push_back(n);
      mesh.tone.push_back(tone);
      mesh.depth_light.push_back(std::clamp(0.25f + 0.75f * layer * (0.45f + 0.55f * s), 0.0f, 1.0f));
      mesh.open.push_back(guide.open[i]);
    }
    if (k + 1 < kPoints) {
      const int q = first + 2 * k;
      mesh.triangles.push_back(Triangle(q, q + 1, q + 2));
      mesh.triangles.push_back(Triangle(q + 1, q + 3, q + 2));
    }
  }
}

// Freedom of the guides' points: rays against the skull, and how deep under the hair's hull the point is.
void light_guides(std::vector<Guide>& guides, const MeshScene& skull) {
  constexpr int rays = 32;
  parallel_for(guides.size(), [&](std::size_t g) {
    Guide& guide = guides[g];
    for (std::size_t k = 0; k < std::size_t(kPoints); ++k) {
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

}  // namespace

float inside_hairline(const std::array<Vec3f, kLandmarkCount>& landmarks, const Vec3f& p) {
  const Proportions a = proportions_of(landmarks);
  const float azimuth = std::atan2(std::abs(p.x()), p.z() - 0.002f);
  const float ragged = 0.003f * noise(p * 130.0f, 900) + 0.003f * noise(p * 45.0f, 901);
  return p.y() - a.brow_y - a.unit * hairline_height(azimuth) + ragged;
}

HairMesh grow_hair(const std::vector<Vec3f>& skull, const std::vector<Triangle>& triangles,
                   const std::array<Vec3f, kLandmarkCount>& landmarks, const HairOptions& options) {
  const Proportions a = proportions_of(landmarks);
  const MeshScene scene(skull, triangles);
  std::vector<Vec3f> normals(skull.size(), Vec3f::Zero());
  std::vector<double> reach;  // running area of the hairy triangles
  std::vector<int> hairy;
  double area = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3f &p = skull[std::size_t(triangles[t][0])], &q = skull[std::size_t(triangles[t][1])],
                &r = skull[std::size_t(triangles[t][2])];
    const Vec3f n = 0.5f * (q - p).cross(r - p);
    for (int k = 0; k < 3; ++k) normals[std::size_t(triangles[t][k])] += n;
    const Vec3f middle = (p + q + r) / 3;
    // An ear's own skin faces all ways close to its plane; hair does not grow there.
    const bool ear = std::abs(middle.x()) > 0.070f * a.unit && middle.y() < a.brow_y + 0.004f &&
                     middle.y() > a.brow_y - 0.08f && std::abs(middle.z() + 0.005f) < 0.045f &&
                     std::abs(n.normalized().x()) < 0.75f;
    if (ear || inside_hairline(landmarks, middle) < 0) continue;
    area += n.norm();
    reach.push_back(area);
    hairy.push_back(int(t));
  }
  for (Vec3f& n : normals) n.normalize();
  HairMesh mesh;
  if (hairy.empty()) return mesh;

  RandomStream random{hash_u32(options.seed + 555)};
  const auto sample = [&](Vec3f& normal) {
    const double pick = area * random.unit();
    const std::size_t i = std::size_t(std::lower_bound(reach.begin(), reach.end(), pick) - reach.begin());
    const Triangle& t = triangles[std::size_t(hairy[std::min(i, hairy.size() - 1)])];
    float u = random.unit(), v = random.unit();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    normal = (normals[std::size_t(t[0])] * (1 - u - v) + normals[std::size_t(t[1])] * u +
              normals[std::size_t(t[2])] * v)
                 .normalized();
    return Vec3f(skull[std::size_t(t[0])] * (1 - u - v) + skull[std::size_t(t[1])] * u +
                 skull[std::size_t(t[2])] * v);
  };
  std::vector<Guide> guides;
  std::vector<std::pair<Vec3f, Vec3f>> roots;
  for (int i = 0; i < options.locks; ++i) {
    Vec3f n;
    const Vec3f root = sample(n);
    roots.emplace_back(root, n);
  }
  guides.resize(roots.size());
  parallel_for(roots.size(), [&](std::size_t i) {
    guides[i] = walk(scene, normals, roots[i].first, roots[i].second, a,
                     hash_u32(options.seed * 31 + std::uint32_t(i)) & 0xffffff00u);
  });
  light_guides(guides, scene);
  const float lock_radius = 1.25f * std::sqrt(float(area) / (3.14159f * float(options.locks)));
  for (const Guide& guide : guides) {
    const float lock_tone = random.between(0.78f, 1.22f);
    const Vec3f n = guide.normals[0];
    const Vec3f e = (std::abs(n.y()) < 0.8f ? n.cross(Vec3f::UnitY()) : n.cross(Vec3f::UnitX())).normalized(),
                f = n.cross(e);
    for (int k = 0; k < options.strands_per_lock; ++k) {
      const float r = lock_radius * std::sqrt(random.unit()), angle = random.between(0, 6.28318f);
      const Vec3f root = guide.root + r * (std::cos(angle) * e + std::sin(angle) * f);
      const float layer = std::pow(random.unit(), 0.6f) * (random.unit() < 0.02f ? 1.35f : 1.0f);
      add_strand(mesh, guide, root, layer, lock_tone * random.between(0.7f, 1.3f), options.width_m, random);
    }
  }
  return mesh;
}

Vec3f shade_hair(const LightRig& rig, const Vec3f& up, const HairPoint& point, const Vec3f& to_eye) {
  const Vec3f base = Vec3f(0.115f, 0.062f, 0.033f) * point.tone;
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
