// A prior on how a person's surface differs from the head model's: a smooth random field on the mesh. Its
// precision is that of a Matern field (Lindgren, Rue and Lindstrom, JRSS B 2011),
//   Q = S^-1 (k^2 M + L) M^-1 (k^2 M + L) S^-1 / (4 pi k^2),
// M the vertices' areas, L the cotangent stiffness, sqrt(8) / k the distance at which two places are nearly
// uncorrelated, S the usual size, which fades to nothing away from the face.
//
// Lids and lips are tied by springs, so that they keep their form; each eyeball, and the hard parts of the
// mouth together, move as one piece with their surroundings.
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "core/head/head_model.h"

namespace likeness {

struct ShapeFieldOptions {
  double usual_m = 0.0025;  // standard deviation of an offset's component on the face
  double range_m = 0.06;    // beyond it, two places of the face differ independently
  double fade_m = 0.03;     // away from the face
  double spring_m = 1e-4;   // by how much the ends of an edge of a lid or lip may differ
};

struct ShapeField {
  std::vector<int> node_of;               // (V) index of the unknown that moves the vertex; -1: none
  int nodes = 0;                          // N
  Eigen::SparseMatrix<double> precision;  // (N, N) 1/m^2, the same for x, y and z
};

// rest: (V) the head whose offsets are sought, without expression, m.
ShapeField shape_field(const HeadModel& model, const std::vector<Vec3f>& rest,
                       const ShapeFieldOptions& options);

// From the line between the closed lips, m.
float lip_distance(const std::array<Vec3f, kLandmarkCount>& landmarks, const Vec3f& point);

}  // namespace likeness
