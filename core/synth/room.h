// The room behind the person: walls, shelves with books, pictures, a window, a desk with things on it and a
// plant. Everything is made of flat textured patches; its light is computed once, on a coarse grid over every
// patch.
#pragma once

#include <memory>
#include <vector>

#include "core/base/linalg.h"
#include "core/synth/shade.h"

namespace likeness {

enum class RoomPaint {
  plaster,
  brick,
  wood,
  floor,
  spine,
  cover,
  poster,
  landscape,
  outdoors,
  cloth,
  leaf,
  plain,
  blank  // its colour and nothing else
};

struct RoomPatch {     // the parallelogram origin + s u + t v, s and t in [0, 1]; outside is cross(u, v)
  Vec3f origin, u, v;  // m
  RoomPaint paint = RoomPaint::plain;
  Vec3f colour = Vec3f::Ones(), other = Vec3f::Zero();  // linear
  std::uint32_t seed = 0;
  float glow = 0;  // of its own light, times the colour
};

// Linear albedo of a patch at (s, t).
Vec3f paint_patch(const RoomPatch& patch, float s, float t);

inline constexpr float kBackWall_m = -1.75f;  // z; the head is at the origin and looks along +z
std::vector<RoomPatch> furnish_room(std::uint32_t seed);
// Nothing but the back wall, so large that it fills every picture: blank, or with plaster on it.
std::vector<RoomPatch> bare_wall(bool plaster);

// The room, ready for rendering. Thread-safe.
class Room {
 public:
  Room(std::vector<RoomPatch> patches, const LightRig& rig);
  ~Room();
  Room(Room&&) noexcept;
  Room& operator=(Room&&) noexcept;

  Vec3f look(const Vec3f& origin, const Vec3f& direction) const;  // linear radiance; world frame

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
