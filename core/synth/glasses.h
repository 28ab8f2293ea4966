// Glasses of the demo person: rims, bridge and side arms as tubes, lenses as curved panes that mirror the
// lights.
#pragma once

#include <array>
#include <vector>

#include "core/base/linalg.h"
#include "core/head/head_model.h"
#include "core/synth/cast.h"
#include "core/synth/hair.h"
#include "core/synth/shade.h"

namespace likeness {

struct Glasses {
  // Rest head frame, m. Empty when none are worn.
  std::vector<Vec3f> frame_vertices, lens_vertices;
  std::vector<Triangle> frame_triangles, lens_triangles;
  std::array<Vec3f, 2> lens_centre;
};

// eyes: centres of the left and the right eyeball. The side arms lie on the skin.
Glasses make_glasses(const Scalp& skin, const std::array<Vec3f, 2>& eyes, const GlassesLook& look);

// What a lens mirrors towards the eye of the camera; everything in the head frame.
Vec3f shade_lens(const Glasses& glasses, const LightRig& rig, const Vec3f& up, const Vec3f& position,
                 const Vec3f& to_eye);

}  // namespace likeness
