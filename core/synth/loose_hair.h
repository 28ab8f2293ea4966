// Long loose hair: guides that leave a parting, fall beside the face or behind the ears, and come to lie on
// the shoulders, from where they hang down over chest or back.
#pragma once

#include <cstdint>

#include "core/synth/hair_guide.h"

namespace likeness {

// What falling hair must not pass through: skin and cloth.
class Drape {
 public:
  Drape(const Scalp& skin, const Cloth& cloth);

  const MeshScene& scene() const { return scene_; }
  bool is_cloth(int triangle) const { return triangle >= first_cloth_; }
  // Moves a point that is nearer to the surface than `distance`, or below it by less than 4 cm, to that
  // distance. Returns the triangle it lies above then, or -1 where it was free; normal: of that triangle.
  int lift(Vec3f& point, float distance, Vec3f& normal) const;

 private:
  int first_cloth_ = 0;
  MeshScene scene_;
};

// root, normal: on the skull. seed: of this guide.
HairGuide walk_loose(const Skull& skull, const Drape& drape, const Vec3f& root, const Vec3f& normal,
                     const HeadProportions& proportions, std::uint32_t seed);

}  // namespace likeness
