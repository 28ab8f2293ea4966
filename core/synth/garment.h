// The demo person's jumper: a knitted tube from a ribbed collar over the shoulders to below the picture.
#pragma once

#include <array>
#include <vector>

#include "core/base/linalg.h"
#include "core/head/head_model.h"
#include "core/synth/cast.h"
#include "core/synth/skin.h"

namespace likeness {

struct Garment {
  std::vector<Vec3f> vertices;  // m, torso frame (the rest head's)
  std::vector<Triangle> triangles;
  std::vector<Vec2f> cloth;  // per vertex, m along and across the knitting
};

// neck: (V) skin of the rest head, from which the collar takes the neck's girth.
Garment make_garment(const std::vector<Vec3f>& skin, const std::array<Vec3f, kLandmarkCount>& landmarks);

// cloth: interpolated coordinates; detail_m: stitches finer than this are left out.
Surface knitted(const Vec2f& cloth, const ClothLook& look, float detail_m, std::uint32_t seed);

}  // namespace likeness
