// The neck between head and torso. The head's field is glued to the head above the chin and to the torso at
// the base of the neck; between the two it turns and shifts with height, so that a head that moves off the
// shoulders takes its neck along without tearing it and without dragging the collar.
//
// A point p of the straight neck, at height y, lies at T(s(y)) p where the head is turned: T(0) is the
// identity, T(1) the torso's motion relative to the head; in between, turn and shift grow evenly about the
// neck's middle; s falls smoothly from 1 at the base to 0 at the top. The neck is straight where head frame
// and torso frame coincide (core/track/torso/torso.h).
#pragma once

#include <array>

#include "core/base/linalg.h"

namespace likeness {

// Where a person's neck is, head frame, m. top <= base: no neck to bend.
struct NeckZone {
  float base = 0, top = 0;  // heights: below the base the torso leads, above the top the head
  Vec3f middle = Vec3f::Zero();

  bool empty() const { return top <= base; }
};

inline constexpr int kNeckSteps = 16;

// One frame's bend, tabulated over s = 0, 1/16 .. 1.
struct NeckBend {
  bool straight = true;     // nothing to do
  float base = 0, top = 0;  // as in the zone
  std::array<Eigen::Matrix3f, kNeckSteps + 1> turn;
  std::array<Vec3f, kNeckSteps + 1> shift;  // straight = turn * posed + shift
  // Its height row alone, an array for each factor: of x, y, z and 1.
  std::array<std::array<float, kNeckSteps + 1>, 4> height;
};

// head_from_torso: world_from_head^-1 world_from_torso. In coordinates (p - origin) / side: those of a
// field's unit cube, or metres with the defaults.
NeckBend make_neck_bend(const NeckZone& zone, const Pose& head_from_torso,
                        const Vec3f& origin = Vec3f::Zero(), float side = 1);

// Where a point near the posed neck lies on the straight one; a point above the top stays. Continuous except
// at folds, where the place nearest to the head is taken.
Vec3f straightened(const NeckBend& bend, const Vec3f& posed);
// The same, up to rounding, with the table's steps in parallel SIMD lanes, since a march needs it for every
// cell of a neck.
Vec3f straightened_in_lanes(const NeckBend& bend, const Vec3f& posed);

// Where a point of the straight neck lies in this bend; one above the top stays.
Vec3f bent(const NeckBend& bend, const Vec3f& straight);

}  // namespace likeness
