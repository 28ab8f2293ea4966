// Mapping a sample to canonical space - the face at rest, the straight neck, the canonical torso - as plain
// tables and arithmetic for a device. Plain C++17. The same as core/scene/warp_lattice.h, mouth_pocket.h,
// neck_bend.h and torso_warp.h, which define the numbers.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"

namespace likeness {

// Geometry of the gap between parted lips, m; slope in m a metre of depth.
constexpr float kGapFront = 0.010f, kGapDepth = 0.070f;  // before and behind the lips
constexpr float kGapLip = 0.006f;                        // thickness of a lip: behind it the gap widens
constexpr float kGapSlope = 0.7f, kGapWidest = 0.012f;
constexpr float kGapBite = 0.0015f;  // least distance over which the rows of teeth are parted

constexpr int kGapColumns = 25, kBendSteps = 16;

struct MouthTable {
  float open;  // 0: lips closed
  float low[3], high[3];
  float right, left;
  float upper_y[kGapColumns], upper_z[kGapColumns], lower_y[kGapColumns], lower_z[kGapColumns];
  float margin[kGapColumns];
  float jaw[3], upper_normal[3], lower_normal[3];
  float upper_height, lower_height;
  float turn[9], shift[3], pocket[3];  // turn: row-major
};

struct LatticeColumn {
  std::int32_t base;
  std::int16_t first, stored;
};

struct LatticeTable {
  std::int32_t nodes[3];  // all 0: nothing moves
  float origin[3], cell, unit;
  MouthTable mouth;
};

struct NeckTable {
  std::int32_t bends;  // 0: straight
  float base, top;
  float turn[kBendSteps + 1][9], shift[kBendSteps + 1][3];  // row-major
  float height[4][kBendSteps + 1];
};

struct TorsoTable {
  std::int32_t columns, rows;  // 0: rigid
  float origin[2], cell;
  std::int32_t hem;  // 0: none
  float hem_height, hem_slope_x, hem_slope_z;
};

LIKENESS_HOST_DEVICE inline float within(float v, float low, float high) {
  return v < low ? low : high < v ? high : v;
}
LIKENESS_HOST_DEVICE inline float dot3(const float* a, const float* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Whether a point of the head frame lies in the gap.
LIKENESS_HOST_DEVICE inline bool in_gap(const MouthTable& gap, const float (&p)[3]) {
  if (gap.open <= 0) return false;
  for (int a = 0; a < 3; ++a)
    if (p[a] < gap.low[a] || p[a] > gap.high[a]) return false;
  const float along = (p[0] - gap.right) / fmaxf(1e-6f, gap.left - gap.right);
  const float beyond = fmaxf(0.f, fmaxf(gap.right - p[0], p[0] - gap.left));
  const float at = within(along, 0.f, 1.f) * (kGapColumns - 1);
  const int i = int(at) < kGapColumns - 2 ? int(at) : kGapColumns - 2;
  const float t = at - float(i);
  const auto look = [&](const float* row) { return row[i] + t * (row[i + 1] - row[i]); };
  const float upper[3] = {p[0], look(gap.upper_y), look(gap.upper_z)};
  const float lower[3] = {p[0], look(gap.lower_y), look(gap.lower_z)};
  const float share = within((p[1] - lower[1]) / fmaxf(1e-6f, upper[1] - lower[1]), 0.f, 1.f);
  const float depth = lower[2] + share * (upper[2] - lower[2]) - p[2];
  if (depth < -kGapFront || depth > kGapDepth) return false;
  const float widens = fminf(fminf(kGapSlope * fmaxf(0.f, depth - kGapLip), kGapWidest), 2 * gap.open);
  const float down[3] = {upper[0] - p[0], upper[1] - p[1], upper[2] - p[2]};
  const float up[3] = {p[0] - lower[0], p[1] - lower[1], p[2] - lower[2]};
  const float inside = fminf(dot3(down, gap.upper_normal), dot3(up, gap.lower_normal));
  return inside - beyond - look(gap.margin) + widens > 0;
}

// Its displacement into the pocket, m.
LIKENESS_HOST_DEVICE inline void way_to_pocket(const MouthTable& gap, const float (&p)[3], float (&way)[3]) {
  const float arm[3] = {p[0] - gap.jaw[0], p[1] - gap.jaw[1], p[2] - gap.jaw[2]};
  const float below_upper = gap.upper_height - dot3(arm, gap.upper_normal);
  const float above_lower = dot3(arm, gap.lower_normal) - gap.lower_height;
  const float apart = fmaxf(kGapBite, below_upper + above_lower);
  const float skull = within(0.5f + 0.5f * (above_lower - below_upper) / apart, 0.f, 1.f);
  for (int a = 0; a < 3; ++a)
    way[a] = gap.pocket[a] + (1 - skull) * (dot3(gap.turn + 3 * a, arm) + gap.shift[a] - arm[a]);
}

// Displacement to canonical at a point of the head frame, m. columns: (y, x); rows: (rows, 3) counts.
LIKENESS_HOST_DEVICE inline void lattice_way(const LatticeTable& lattice, const LatticeColumn* columns,
                                             const std::int16_t* rows, const float (&p)[3], float (&way)[3]) {
  way[0] = way[1] = way[2] = 0;
  if (in_gap(lattice.mouth, p)) return way_to_pocket(lattice.mouth, p, way);
  float share[3];
  int node[3];
  for (int a = 0; a < 3; ++a) {
    const float at = (p[a] - lattice.origin[a]) * (1 / lattice.cell);
    if (!(at >= 0 && at < float(lattice.nodes[a] - 1))) return;
    node[a] = int(at), share[a] = at - float(node[a]);
  }
  for (int c = 0; c < 4; ++c) {
    const LatticeColumn column = columns[(node[1] + (c >> 1)) * lattice.nodes[0] + node[0] + (c & 1)];
    const int along = node[2] + 1 - column.first;
    const bool kept = along >= 0 && along <= column.stored;
    const std::int16_t* near = rows + (kept ? 3 * (std::ptrdiff_t(column.base) + node[2]) : 0);
    const float weight = (c & 1 ? share[0] : 1 - share[0]) * (c >> 1 ? share[1] : 1 - share[1]);
    for (int a = 0; a < 3; ++a)
      way[a] += weight * ((1 - share[2]) * float(near[a]) + share[2] * float(near[3 + a]));
  }
  for (int a = 0; a < 3; ++a) way[a] *= lattice.unit;
}

// Where a point near the posed neck lies on the straight one; one above the top stays.
LIKENESS_HOST_DEVICE inline void straighten(const NeckTable& bend, float (&p)[3]) {
  if (!bend.bends || p[1] >= bend.top) return;
  const float per_height = 1 / (bend.top - bend.base);
  const auto excess = [&](int k) {
    const float y =
        bend.height[0][k] * p[0] + bend.height[1][k] * p[1] + bend.height[2][k] * p[2] + bend.height[3][k];
    const float u = within((bend.top - y) * per_height, 0.f, 1.f);
    return float(k) / kBendSteps - u * u * (3 - 2 * u);
  };
  int high = 1;
  float at_low = excess(0), at_high = excess(1);
  while (at_high < 0 && high < kBendSteps) at_low = at_high, at_high = excess(++high);
  const int low = high - 1;
  const float width = at_high - at_low;
  const float share = width > 0 ? within(-at_low / width, 0.f, 1.f) : 0.f;
  float straight[3];
  for (int a = 0; a < 3; ++a) {
    const float from = dot3(bend.turn[low] + 3 * a, p) + bend.shift[low][a];
    const float to = dot3(bend.turn[high] + 3 * a, p) + bend.shift[high][a];
    straight[a] = (1 - share) * from + share * to;
  }
  for (int a = 0; a < 3; ++a) p[a] = straight[a];
}

// The inverse: where a point of the straight neck lies in this bend.
LIKENESS_HOST_DEVICE inline void bend_neck(const NeckTable& bend, float (&p)[3]) {
  if (!bend.bends || p[1] >= bend.top) return;
  const float u = within((bend.top - p[1]) / (bend.top - bend.base), 0.f, 1.f);
  const float s = u * u * (3 - 2 * u) * kBendSteps;
  const int low = int(s) < kBendSteps - 1 ? int(s) : kBendSteps - 1;
  const float share = s - float(low);
  float posed[3] = {0, 0, 0};
  for (int step = 0; step < 2; ++step) {
    const float *turn = bend.turn[low + step], *shift = bend.shift[low + step];
    const float arm[3] = {p[0] - shift[0], p[1] - shift[1], p[2] - shift[2]};
    for (int a = 0; a < 3; ++a)
      posed[a] += (step == 0 ? 1 - share : share) *
                  (turn[a] * arm[0] + turn[3 + a] * arm[1] + turn[6 + a] * arm[2]);  // its transpose
  }
  for (int a = 0; a < 3; ++a) p[a] = posed[a];
}

// Canonical minus posed at a place of the torso frame, m, without the hem; nothing moves along z.
// displacement: (rows, columns, 2).
LIKENESS_HOST_DEVICE inline void torso_grid_way(const TorsoTable& torso, const float* displacement, float x,
                                                float y, float (&way)[2]) {
  way[0] = way[1] = 0;
  if (torso.columns == 0) return;
  const float u = within((x - torso.origin[0]) / torso.cell, 0.f, float(torso.columns - 1));
  const float v = within((y - torso.origin[1]) / torso.cell, 0.f, float(torso.rows - 1));
  const int column = int(u) < torso.columns - 2 ? int(u) : torso.columns - 2;
  const int row = int(v) < torso.rows - 2 ? int(v) : torso.rows - 2;
  const float a = u - float(column), b = v - float(row);
  for (int c = 0; c < 4; ++c) {
    const float weight = (c & 1 ? a : 1 - a) * (c >> 1 ? b : 1 - b);
    const float* at = displacement + 2 * ((row + (c >> 1)) * torso.columns + column + (c & 1));
    way[0] += weight * at[0], way[1] += weight * at[1];
  }
}

// The same, then up to the hem.
LIKENESS_HOST_DEVICE inline void torso_way(const TorsoTable& torso, const float* displacement,
                                           const float* place, float (&way)[2]) {
  torso_grid_way(torso, displacement, place[0], place[1], way);
  if (torso.hem == 0) return;
  const float lowest =
      torso.hem_height + torso.hem_slope_x * (place[0] + way[0]) + torso.hem_slope_z * place[2] - place[1];
  if (way[1] < lowest) way[1] = lowest;
}

}  // namespace likeness
