// Hair and beard of the demo person: some tens of thousands of thin ribbons combed over the scalp or hanging
// from it, grouped in locks.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "core/base/linalg.h"
#include "core/head/head_model.h"
#include "core/synth/cast.h"
#include "core/synth/hair_guide.h"
#include "core/synth/shade.h"

namespace likeness {

struct HairMesh {
  std::vector<Vec3f> vertices;  // m, rest head frame
  std::vector<Triangle> triangles;
  // Per vertex:
  std::vector<Vec3f> tangents;     // unit, root to tip
  std::vector<Vec3f> outward;      // unit normal of the scalp below
  std::vector<float> tone;         // of the strand, about 1
  std::vector<float> white;        // 0 of the hair's colour, 1 white
  std::vector<float> depth_light;  // 0 deep inside the hair .. 1 at its surface
  // Share of free directions as a function of direction: open[0] + open.tail(3) . d, from the lock's own
  // rays.
  std::vector<Eigen::Vector4f> open;
  std::vector<int> anchor;  // beard only: the skin's triangle it grows on, with which it moves
  // Loose hair only: 1 moves with the head, 0 lies on the torso and moves with it.
  std::vector<float> follow;
};

struct HairOptions {
  int locks = 1500;
  int strands_per_lock = 22;
  float width_m = 0.0007f;
  HairLook look;
  std::uint32_t seed = 0;
};

// How far the point lies inside the hairline: < 0 outside, > 0 inside, in metres along the skin, roughly.
float inside_hairline(const std::array<Vec3f, kLandmarkCount>& landmarks, HairCut cut, const Vec3f& point);

// cloth: what loose hair falls on.
HairMesh grow_hair(const Scalp& skin, const Cloth& cloth, const HairOptions& options);
// Whether hair of this cut hangs below the ears and moves against the head.
bool hangs(HairCut cut);
// share: how thickly the beard grows at a point, 0..1. look.beard: its length over the chin.
HairMesh grow_beard(const Scalp& skin, const std::function<float(const Vec3f&)>& share,
                    const HairOptions& options);

// Radiance towards the eye of a point of the hair. All vectors in the head frame, where `rig` must be too.
struct HairPoint {
  Vec3f position, tangent, outward;
  Vec3f colour = Vec3f(0.115f, 0.062f, 0.033f);  // linear albedo
  float depth_light = 1;
  Eigen::Vector4f open = Eigen::Vector4f(1, 0, 0, 0);
};
Vec3f shade_hair(const LightRig& rig, const Vec3f& up, const HairPoint& point, const Vec3f& to_eye);

}  // namespace likeness
