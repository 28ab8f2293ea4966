// Surface of the demo person as a solid texture: a function of the point of the rest-pose head, laid out by
// its 68 landmarks (lips, brows, lid margins, cheeks), so that it fits any head model and needs no texture
// coordinates.
#pragma once

#include <array>
#include <vector>

#include "core/base/linalg.h"
#include "core/head/head_model.h"
#include "core/synth/cast.h"

namespace likeness {

struct Surface {
  Vec3f albedo = Vec3f::Zero();  // linear
  float roughness = 0.5f, f0 = 0.03f;
  float coat = 0;               // sharp wet reflection on top, 0..1
  Vec3f slope = Vec3f::Zero();  // gradient of the fine relief, m / m, in rest coordinates
};

class Skin {
 public:
  // landmarks of the neutral head; eyes: centres of the left and the right eyeball. detail_m: relief and
  // pores finer than this are left out (the size of a pixel on the face).
  Skin(const std::array<Vec3f, kLandmarkCount>& landmarks, const std::array<Vec3f, 2>& eyes, float eye_radius,
       const SkinLook& look, float detail_m, std::uint32_t seed);

  // Where a beard grows, 0..1.
  float stubble(const Vec3f& point) const;
  // On the lips, 0..1.
  float lip(const Vec3f& point) const;

  // `point` on the rest head; for an eyeball, undo the eye's rotation first (rest vertices interpolated over
  // the triangle need no such step).
  Surface at(const Vec3f& point, HeadPart part) const;

 private:
  Surface face(const Vec3f& point) const;
  Surface eyeball(const Vec3f& point, const Vec3f& centre) const;
  float brow(const Vec3f& point) const;
  float lash_line(const Vec3f& point) const;
  float lines(const Vec3f& point) const;

  std::array<Vec3f, kLandmarkCount> landmarks_;
  std::array<Vec3f, 2> eyes_;
  SkinLook look_;
  float eye_radius_, detail_, unit_;  // unit: distance of the eye centres over the usual 62 mm
  std::uint32_t seed_;
  std::array<std::vector<Vec3f>, 2> brows_, upper_lids_, lower_lids_;  // polylines, subject's right first
  std::vector<Vec3f> lips_;                                            // closed outline
};

}  // namespace likeness
