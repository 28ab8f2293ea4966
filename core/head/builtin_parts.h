// The left half of the built-in head as a mesh, and the pieces it is made of. Millimetres. Internal to
// core/head.
#pragma once

#include <vector>

#include "core/head/builtin_chart.h"
#include "core/head/head_model.h"

namespace likeness::builtin {

// What a vertex is on, for skinning, identity and expressions.
enum class Tissue { skin, lid_inner, lip_inner, eyeball, upper_teeth, lower_teeth, tongue, ear };

struct HalfVertex {
  Vec3d position;  // mm
  HeadPart part = HeadPart::face;
  Tissue tissue = Tissue::skin;
  bool midline = false;      // shared with the right half
  double lid = 0;            // 0 away from the eye .. 1 at the lid margin and behind it
  double lip = 0;            // 0 away from the mouth, 1 at the vermilion border, 2 at the seam, 3 the throat
  int mouth_side = 0;        // +1 upper lip and above, -1 lower, 0 not in the mouth's rings
  double along_lip = 0;      // 0 midline .. 1 corner, in the mouth's rings
  Vec2d uv = Vec2d::Zero();  // left half's; the mirror image uses (1 - u, v)
};

struct HalfMesh {
  std::vector<HalfVertex> vertices;
  std::vector<Triangle> triangles;
};

// Front-view curves of the opening between the lids, mm. Zero offsets are the neutral, open eye.
struct EyeOpening {
  double upper = 5.9,
         lower = 4.7;  // height of the upper and lower lid margin over and under the corners' line
  Vec2d inner = Vec2d::Zero(), outer = Vec2d::Zero();  // shifts of the corners
  double lean = 0;                                     // > 0 moves the arcs' peaks towards the temple
};
Vec2d lid_margin(const EyeOpening& opening, double along, bool upper);  // along: 0 inner corner .. 1 outer
inline const EyeOpening kEyeOpen{};
inline const EyeOpening kEyeClosed{-3.35, 3.4};

// Front-view curves of the lips, mm. along: 0 midline .. 1 corner.
enum class LipCurve { upper_border, upper_seam, lower_seam, lower_border };
Vec2d lip_point(LipCurve curve, double along);

struct Skin {
  HalfMesh mesh;
  Chart chart;
  std::vector<std::vector<int>> eye_rings;    // [ring][k] vertex, ring 0 on the grid
  std::vector<std::vector<int>> mouth_rings;  // [ring][k]
};
Skin make_skin();

// Positions of the skin's eye rings for another opening: (rings, k), as Skin::eye_rings; ring 0 is unchanged.
std::vector<std::vector<Vec3d>> eye_ring_positions(const Skin& skin, const EyeOpening& opening);

// A point of the torso below a column of the neck: t from 0 (the neck's last row) to 1 (the bust's lower
// edge). `slope` is the neck's direction there, per row.
Vec3d torso_at(const Vec3d& neck, const Vec3d& slope, double azimuth, double t);

HalfMesh make_eyeball();
HalfMesh make_ear();
HalfMesh make_teeth(bool upper);
HalfMesh make_tongue();

// Appends `piece`, whose quads may be built with add_quad.
void append(HalfMesh& mesh, const HalfMesh& piece);
void add_quad(HalfMesh& mesh, int a, int b, int c, int d);  // counter-clockwise from outside

}  // namespace likeness::builtin
