// The inside of an open mouth in canonical space. The resting face has none: its lips are closed, and mapping
// the lips back would fold everything between them onto their seam. So points in the gap are moved to a
// pocket, a copy of the mouth deep inside the skull, where a resting head is never seen.
//
// In the pocket the jaw is always open by one angle. The upper teeth are fixed to the skull and the lower
// ones to the jaw, so the gap between the planes of the two rows is stretched and everything beyond follows
// its row rigidly: teeth stay where they are in the pocket however far the mouth opens, and an opening wider
// than any seen shows the same pocket.
//
// A point is in the gap when it lies between the inner edges of the lips, a margin off them; behind the lips
// the gap widens. The decision is sharp, as lips are: along their edge the canonical place jumps.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/head/pose_head.h"

namespace likeness {

inline constexpr int kLipColumns = 25;

// Inner edges of the lips over equal columns from the right to the left corner, head frame, m.
struct LipEdges {
  float right = 0, left = 0;  // x of the corners
  std::array<float, kLipColumns> upper_y{}, upper_z{}, lower_y{}, lower_z{};
};

// What all frames of a person share.
struct MouthFrame {
  struct Mark {
    Triangle vertices = Triangle::Zero();
    Vec3f weights = Vec3f::Zero();
  };
  std::array<Mark, 8> lips;                 // inner contour of the lips, landmarks 60..67
  std::array<Mark, 3> chin;                 // landmarks 7..9
  Vec3f chin_rest = Vec3f::Zero();          // their mean at rest, m
  Vec3f jaw = Vec3f::Zero();                // the jaw's joint, m
  Vec3f bite = Vec3f::Zero();               // a point where the rows of teeth meet, m
  Vec3f up = Vec3f::UnitY();                // normal of the plane in which they meet
  Vec3f pocket = Vec3f::Zero();             // from the open mouth to the pocket, m
  std::array<float, kLipColumns> margin{};  // m off the edge of a lip
};
MouthFrame make_mouth_frame(const HeadModel& model, const HeadShape& shape, std::span<const Vec3f> rest);

// One frame's gap.
struct MouthGap {
  float open = 0;  // m, half of the widest opening beyond the margins; 0: lips closed, nothing is in the gap
  Vec3f low = Vec3f::Zero(), high = Vec3f::Zero();  // box of the gap, m
  LipEdges edges;
  std::array<float, kLipColumns> margin{};
  Vec3f jaw = Vec3f::Zero();                                           // m
  Vec3f upper_normal = Vec3f::UnitY(), lower_normal = Vec3f::UnitY();  // of the planes of the two rows
  float upper_height = 0, lower_height = 0;                            // m, of the planes over the joint
  Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();                  // of the jaw, to the pocket's opening
  Vec3f shift = Vec3f::Zero();                                         // m, of the jaw
  Vec3f pocket = Vec3f::Zero();                                        // m
};
MouthGap make_mouth_gap(const MouthFrame& frame, std::span<const Vec3f> posed);

// Whether a point of the head frame lies in the gap.
bool in_gap(const MouthGap& gap, const Vec3f& point);
// Displacement of a point in the gap into the pocket, m.
Vec3f way_to_pocket(const MouthGap& gap, const Vec3f& point);

}  // namespace likeness
