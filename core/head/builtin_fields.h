// Displacement fields over the whole built-in head: what an identity direction or an expression does to every
// vertex. Millimetres. Internal to core/head.
#pragma once

#include <string>
#include <vector>

#include "core/head/builtin_parts.h"

namespace likeness::builtin {

// The head with both halves. Vertex i of the right half mirrors `twin[i]`; a vertex on the midline is its own
// twin.
struct WholeHead {
  Skin skin;                         // the left half's skin, whose vertices come first
  std::vector<HalfVertex> vertices;  // left half first; mirrored ones have negated x and the right eye's part
  std::vector<int> twin;             // (V)
  int left_count = 0;                // vertices [0, left_count) are the left half, midline included
  std::vector<Triangle> triangles;
};
WholeHead make_whole_head();

// Skinning weight of the jaw at a vertex, 0..1.
double jaw_weight(const HalfVertex& vertex);
inline const Vec3d kJawJoint(0, 3, 16), kNeckJoint(0, -88, -14), kRootJoint(0, -165, -24);  // mm

using Field = std::vector<Vec3d>;  // (V) mm

// A push that fades as a Gaussian of the distance measured in `radii`; mirrored to the other side when
// off-centre.
struct Bump {
  Vec3d centre, radii, push;  // mm
};
Vec3d bump_at(const Bump& bump, const Vec3d& point);

// The left half of a symmetric field, copied to the right half by reflection.
Field mirrored(const WholeHead& head, const Field& left);
// The part of a symmetric field on one side; the two sides add up to the field.
Field one_side(const WholeHead& head, const Field& symmetric, bool left);
// The effect of changing the opening between the lids.
Field lid_field(const WholeHead& head, const EyeOpening& opening);

struct NamedField {
  std::string name;
  Field field;
};
std::vector<NamedField> identity_fields(const WholeHead& head);    // per standard deviation
std::vector<NamedField> expression_fields(const WholeHead& head);  // at full action

}  // namespace likeness::builtin
