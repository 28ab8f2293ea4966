// Light and surface models of the demo's renderer. Radiance is linear RGB, 1.0 about a white wall in the key
// light.
#pragma once

#include <array>
#include <functional>

#include "core/base/linalg.h"

namespace likeness {

struct AreaLight {               // a rectangle that shines to the side of cross(half_u, half_v)
  Vec3f centre, half_u, half_v;  // m
  Vec3f radiance;
};

// The light of the demo: a key, a weak fill, a rim from behind, and the room's own glow.
struct LightRig {
  AreaLight key, fill, rim;
  Vec3f ceiling, walls, floor;     // glow by direction
  Vec3f outdoors = Vec3f::Ones();  // what the room's window shows, times this

  Vec3f glow(const Vec3f& direction) const;  // unit direction
};

// 0: a large soft window from the side. 1: the ceiling light of a room, cooler and from above. 2: a warm lamp
// in the evening, hard and from below the eyes' height, the rest nearly dark. In the world frame.
LightRig make_light_rig(int light = 0);
LightRig transform_rig(const LightRig& rig,
                       const Pose& to_from_rig);  // into another frame; `up` turns with it

// Is the segment from `origin` along the unit `direction` up to `distance` free?
using Visible = std::function<bool(const Vec3f& origin, const Vec3f& direction, float distance)>;

// Light that falls on a point, before it is multiplied with the albedo.
struct Received {
  Vec3f diffuse = Vec3f::Zero();     // irradiance / pi: with albedo 1 the outgoing radiance
  float key_open = 0, rim_open = 0;  // visible share of the lights, [0, 1]
  float sky_open = 0;                // cosine-weighted visible share of the hemisphere
};

struct GatherOptions {
  int light_grid = 3;  // shadow rays to the key: the square of this
  int sky_rays = 16;
  float sky_reach = 0.25f;  // m; things further away do not darken
  Vec3f wrap =
      Vec3f::Zero();  // how far past the terminator light reaches, per channel (scattering under the skin)
  float bounce = 0;   // share of the missing sky that comes back as light of `bounce_colour`
  Vec3f bounce_colour = Vec3f::Ones();
};

// pattern: any number; chooses the rotation of the sampling pattern, so that neighbours do not show banding.
Received gather_light(const LightRig& rig, const Vec3f& up, const Vec3f& position, const Vec3f& normal,
                      const Visible& visible, const GatherOptions& options, std::uint32_t pattern);

// Radiance of a rectangle's glossy reflection (GGX about the direction nearest to the mirror one). Unit
// vectors; `to_eye` from the surface to the camera; f0 = reflectance at normal incidence.
Vec3f glossy(const AreaLight& light, const Vec3f& position, const Vec3f& normal, const Vec3f& to_eye,
             float roughness, float f0);

float fresnel(float f0, float cosine);

// Linear radiance to display-referred sRGB in [0, 1]: soft shoulder, then the sRGB curve.
Vec3f develop(const Vec3f& radiance);
Vec3f linear_colour(float red, float green, float blue);  // sRGB in [0, 1] -> linear

}  // namespace likeness
