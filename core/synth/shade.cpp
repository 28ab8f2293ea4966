// Area lights are sampled on a fixed grid, the sky on a spiral of cosine-distributed directions.
#include "core/synth/shade.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/image/srgb.h"
#include "core/synth/noise.h"

namespace likeness {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

AreaLight moved(const AreaLight& light, const Eigen::Isometry3f& m) {
  return {m * light.centre, m.linear() * light.half_u, m.linear() * light.half_v, light.radiance};
}

// Two unit vectors that complete n to a frame.
void tangents(const Vec3f& n, Vec3f& a, Vec3f& b) {
  a = (std::abs(n.x()) < 0.7f ? n.cross(Vec3f::UnitX()) : n.cross(Vec3f::UnitY())).normalized();
  b = n.cross(a);
}

struct LightSum {
  Vec3f diffuse = Vec3f::Zero();
  float open = 0;
};

LightSum light_from(const AreaLight& light, const Vec3f& position, const Vec3f& normal,
                    const Visible& visible, int grid, const Vec3f& wrap, std::uint32_t pattern) {
  LightSum sum;
  const Vec3f out = light.half_u.cross(light.half_v);
  const float area = 4 * out.norm();
  const Vec3f out_unit = out / (area / 4);
  const float widest = wrap.maxCoeff();
  float total = 0;
  for (int i = 0; i < grid; ++i) {
    for (int j = 0; j < grid; ++j) {
      const std::uint32_t h = pattern * 64 + std::uint32_t(i * grid + j);
      const float u = 2 * (float(i) + hash_unit(h)) / float(grid) - 1;
      const float v = 2 * (float(j) + hash_unit(h ^ 0x5bd1e995U)) / float(grid) - 1;
      const Vec3f to = light.centre + u * light.half_u + v * light.half_v - position;
      const float distance = to.norm();
      const Vec3f d = to / distance;
      const float at_light = -d.dot(out_unit), here = normal.dot(d);
      total += 1;
      if (at_light <= 0 || here <= -widest) continue;
      if (!visible(position, d, distance - 0.002f)) continue;
      sum.open += 1;
      const float form = at_light * area / (kPi * distance * distance);
      const Eigen::Array3f w = wrap.array();
      const Eigen::Array3f lambert = ((here + w) / (1 + w)).max(0.0f) / (1 + w);
      sum.diffuse += (light.radiance.array() * lambert * form).matrix();
    }
  }
  sum.diffuse /= total;
  sum.open /= total;
  return sum;
}

}  // namespace

Vec3f LightRig::glow(const Vec3f& d) const {
  const float up = d.y();
  return up > 0 ? mix(walls, ceiling, smoothstep(0.0f, 0.8f, up))
                : mix(walls, floor, smoothstep(0.0f, 0.7f, -up));
}

namespace {

LightRig ceiling_light() {
  LightRig rig;
  rig.key = {Vec3f(-0.10f, 1.25f, 0.80f), Vec3f(0.40f, 0, 0), Vec3f(0, 0.10f, 0.40f),
             Vec3f(11.2f, 11.9f, 12.2f)};
  rig.fill = {Vec3f(0.5f, -0.45f, 1.3f), Vec3f(0.6f, 0, 0.1f), Vec3f(0, 0.2f, -0.5f),
              Vec3f(1.0f, 0.98f, 0.92f)};
  rig.rim = {Vec3f(0.3f, 1.2f, -0.8f), Vec3f(0.3f, 0, 0), Vec3f(0, 0.1f, 0.3f), Vec3f(3.4f, 3.6f, 3.7f)};
  rig.ceiling = Vec3f(0.58f, 0.61f, 0.62f);
  rig.walls = Vec3f(0.40f, 0.41f, 0.41f);
  rig.floor = Vec3f(0.20f, 0.19f, 0.18f);
  rig.outdoors = Vec3f(0.75f, 0.80f, 0.88f);
  return rig;
}

LightRig evening_lamp() {
  LightRig rig;
  rig.key = {Vec3f(-0.92f, 0.10f, 0.95f), Vec3f(0.12f, 0, 0.12f), Vec3f(0, 0.16f, 0),
             Vec3f(58.0f, 41.0f, 25.0f)};
  rig.fill = {Vec3f(1.3f, 0.3f, 1.2f), Vec3f(0.35f, 0, -0.35f), Vec3f(0, 0.5f, 0),
              Vec3f(0.62f, 0.70f, 0.95f)};
  rig.rim = {Vec3f(0.9f, 0.5f, -1.0f), Vec3f(0.2f, 0, 0.2f), Vec3f(0, 0.2f, 0), Vec3f(2.6f, 2.0f, 1.3f)};
  rig.ceiling = Vec3f(0.16f, 0.125f, 0.095f);
  rig.walls = Vec3f(0.135f, 0.108f, 0.085f);
  rig.floor = Vec3f(0.060f, 0.046f, 0.034f);
  rig.outdoors = Vec3f(0.05f, 0.07f, 0.12f);
  return rig;
}

void face_the_head(LightRig& rig) {
  for (AreaLight* light : {&rig.key, &rig.fill, &rig.rim}) {
    if (light->half_u.cross(light->half_v).dot(light->centre) > 0) light->half_v = -light->half_v;
  }
}

LightRig window_light() {
  LightRig rig;
  // World: the head at the origin looks along +z. The subject's left is +x.
  rig.key = {Vec3f(0.82f, 0.80f, 1.50f), Vec3f(0.46f, 0, -0.26f), Vec3f(0.17f, 0.47f, 0.21f),
             Vec3f(12.0f, 11.3f, 10.3f)};
  rig.fill = {Vec3f(-1.5f, 0.35f, 1.1f), Vec3f(0.30f, 0, 0.42f), Vec3f(0, 0.5f, 0), Vec3f(3.1f, 3.3f, 3.6f)};
  rig.rim = {Vec3f(-0.75f, 0.85f, -1.0f), Vec3f(0.25f, 0, -0.2f), Vec3f(0.1f, 0.25f, 0.15f),
             Vec3f(5.4f, 5.7f, 6.3f)};
  rig.ceiling = Vec3f(0.50f, 0.485f, 0.47f);
  rig.walls = Vec3f(0.30f, 0.285f, 0.27f);
  rig.floor = Vec3f(0.12f, 0.095f, 0.08f);
  return rig;
}

}  // namespace

LightRig make_light_rig(int light) {
  LightRig rig = light == 1 ? ceiling_light() : light == 2 ? evening_lamp() : window_light();
  face_the_head(rig);
  return rig;
}

LightRig transform_rig(const LightRig& rig, const Pose& to_from_rig) {
  const Eigen::Isometry3f m = to_from_rig.cast<float>();
  LightRig result = rig;
  result.key = moved(rig.key, m);
  result.fill = moved(rig.fill, m);
  result.rim = moved(rig.rim, m);
  return result;
}

Received gather_light(const LightRig& rig, const Vec3f& up, const Vec3f& position, const Vec3f& normal,
                      const Visible& visible, const GatherOptions& options, std::uint32_t pattern) {
  Received received;
  const Vec3f start = position + 0.0006f * normal;
  const LightSum key = light_from(rig.key, start, normal, visible, options.light_grid, options.wrap, pattern);
  const LightSum fill = light_from(rig.fill, start, normal, visible, std::max(1, options.light_grid - 1),
                                   options.wrap, pattern + 1);
  const LightSum rim = light_from(rig.rim, start, normal, visible, std::max(1, options.light_grid - 1),
                                  options.wrap, pattern + 2);
  received.diffuse = key.diffuse + fill.diffuse + rim.diffuse;
  received.key_open = key.open;
  received.rim_open = rim.open;

  Vec3f a, b;
  tangents(normal, a, b);
  const float spin = 2 * kPi * hash_unit(pattern + 3);
  Vec3f sky = Vec3f::Zero();
  // Glow depends on the direction against `up`, which is world-up seen from this frame.
  for (int i = 0; i < options.sky_rays; ++i) {
    const float r2 = (float(i) + 0.5f) / float(options.sky_rays), angle = spin + 2.399963f * float(i);
    const float r = std::sqrt(r2), z = std::sqrt(1 - r2);
    const Vec3f d = r * std::cos(angle) * a + r * std::sin(angle) * b + z * normal;
    if (!visible(start, d, options.sky_reach)) continue;
    received.sky_open += 1;
    sky += rig.glow(Vec3f(0, d.dot(up), 0));
  }
  if (options.sky_rays > 0) {
    received.sky_open /= float(options.sky_rays);
    received.diffuse += sky / float(options.sky_rays);
    received.diffuse += (options.bounce * (1 - received.sky_open) * options.bounce_colour.array() *
                         (rig.walls.array() + 0.5f * key.diffuse.array()))
                            .matrix();
  }
  return received;
}

float fresnel(float f0, float cosine) {
  const float m = 1 - std::clamp(cosine, 0.0f, 1.0f), m2 = m * m;
  return f0 + (1 - f0) * m2 * m2 * m;
}

Vec3f glossy(const AreaLight& light, const Vec3f& position, const Vec3f& normal, const Vec3f& to_eye,
             float roughness, float f0) {
  // Representative point: where the mirror ray meets the light's plane, pulled back into the rectangle.
  const Vec3f mirror = 2 * normal.dot(to_eye) * normal - to_eye;
  const Vec3f out = light.half_u.cross(light.half_v);
  const Vec3f to_centre = light.centre - position;
  const float facing = mirror.dot(out);
  float u = 0, v = 0;
  if (facing < -1e-6f) {
    const Vec3f on_plane = mirror * (to_centre.dot(out) / facing) - to_centre;
    u = std::clamp(on_plane.dot(light.half_u) / light.half_u.squaredNorm(), -1.0f, 1.0f);
    v = std::clamp(on_plane.dot(light.half_v) / light.half_v.squaredNorm(), -1.0f, 1.0f);
  }
  const Vec3f to = to_centre + u * light.half_u + v * light.half_v;
  const float distance = to.norm();
  const Vec3f d = to / distance;
  const float here = normal.dot(d), there = -d.dot(out) / out.norm(),
              eye = std::max(0.05f, normal.dot(to_eye));
  if (here <= 0 || there <= 0) return Vec3f::Zero();
  const Vec3f half = (d + to_eye).normalized();
  const float nh = std::max(0.0f, normal.dot(half)), alpha = roughness * roughness;
  // The light's angular radius widens the lobe and, to keep its energy, lowers its peak.
  const float angular = std::sqrt(4 * out.norm() * there / kPi) / distance;
  const float wide = std::min(1.0f, alpha + 0.33f * angular);
  const float q = nh * nh * (wide * wide - 1) + 1;
  const float lobe = wide * wide / (kPi * q * q);
  const float k = 0.5f * alpha + 1e-4f;
  const float shadowing = 1 / ((here * (1 - k) + k) * (eye * (1 - k) + k));
  const float solid = 4 * out.norm() * there / (distance * distance);
  return light.radiance *
         (0.25f * lobe * shadowing * fresnel(f0, d.dot(half)) * here * std::min(solid, 1.5f));
}

Vec3f develop(const Vec3f& radiance) {
  Vec3f result;
  for (int c = 0; c < 3; ++c) {
    const float x = std::max(0.0f, radiance[c]);
    const float t = x < 0.6f ? x : 0.6f + 0.4f * (1 - std::exp(-(x - 0.6f) / 0.4f));
    result[c] = srgb_of_linear(t);
  }
  return result;
}

Vec3f linear_colour(float red, float green, float blue) {
  return {linear_of_srgb(red), linear_of_srgb(green), linear_of_srgb(blue)};
}

}  // namespace likeness
