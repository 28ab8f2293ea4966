// The chart of the built-in head's skin: (column, row) real numbers -> a ray from the head's axis -> the
// skin. Columns go from the front midline (0) round the subject's left to the back; rows from the crown (0)
// to the bottom of the torso. Integer pairs are the mesh's grid. Millimetres. Internal to core/head.
#pragma once

#include <vector>

#include "core/base/linalg.h"

namespace likeness::builtin {

struct Chart {
  std::vector<double> azimuth;                          // (columns) rad, 0 .. pi
  std::vector<double> origin_y, origin_z;               // (rows) mm
  std::vector<double> front_elevation, back_elevation;  // (rows) rad
  int columns() const { return int(azimuth.size()); }
  int rows() const { return int(origin_y.size()); }
};

Chart make_chart();

// at = (column, row).
Vec3d skin_at(const Chart& chart, const Vec2d& at);

// The place of a point on the chart (its ray goes through the point).
Vec2d chart_of(const Chart& chart, const Vec3d& point);

}  // namespace likeness::builtin
