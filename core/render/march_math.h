// The walk of a ray through a field's grid (Amanatides & Woo 1987), crossing empty bricks in one step, for
// processor and device. Plain C++17.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/render/ray_samples.h"
#include "core/render/strata_math.h"

namespace likeness {

constexpr int kBrick = 8;  // cells a side: one byte of a grid's bits along x
LIKENESS_HOST_DEVICE inline int bricks_along(int resolution) { return (resolution + kBrick - 1) / kBrick; }

// In a field's unit cube, as FieldRay in rays.h.
struct UnitRay {
  float origin[3], direction[3];
};

// Where the ray is inside the unit cube; near > far if it misses, or is not a valid ray.
LIKENESS_HOST_DEVICE inline Interval cube_interval(const UnitRay& ray, float near, float far) {
  for (int a = 0; a < 3; ++a) {
    const float d = ray.direction[a], o = ray.origin[a];
    if (!(d - d == 0) || !(o - o == 0)) return {1, 0, 0};  // not finite
    if (std::fabs(d) < 1e-12f) {
      if (o < 0 || o > 1) return {1, 0, 0};
      continue;
    }
    const float t0 = -o / d, t1 = (1 - o) / d;
    near = larger(near, smaller(t0, t1));
    far = smaller(far, larger(t0, t1));
  }
  return {near, far, 0};
}

// The cell along an axis that holds a place, both in cells; the first or last one where it lies beyond them.
LIKENESS_HOST_DEVICE inline int cell_at(float place, int first, int last) {
  return int(bounded(place, float(first), float(last)));  // none is negative
}

// A ray's path through cells, in units of cells.
struct CellWalk {
  float origin[3], direction[3];
  float next[3], delta[3];  // distance (m) at which the ray leaves its cell along an axis; between two such
  int cell[3], step[3], n = 0;

  LIKENESS_HOST_DEVICE CellWalk(const UnitRay& ray, int resolution, float near) : n(resolution) {
    for (int a = 0; a < 3; ++a) {
      origin[a] = ray.origin[a] * float(n), direction[a] = ray.direction[a] * float(n);
      cell[a] = cell_at(origin[a] + near * direction[a], 0, n - 1);
      step[a] = direction[a] > 0 ? 1 : -1;
      enter(a);
    }
  }
  LIKENESS_HOST_DEVICE bool runs_along(int a) const { return std::fabs(direction[a]) >= 1e-9f; }
  LIKENESS_HOST_DEVICE void enter(int a) {
    next[a] = delta[a] = INFINITY;
    if (!runs_along(a)) return;
    delta[a] = std::fabs(1 / direction[a]);
    next[a] = (float(cell[a] + (direction[a] > 0)) - origin[a]) / direction[a];
  }
  LIKENESS_HOST_DEVICE float leaves_cell() const { return smaller(smaller(next[0], next[1]), next[2]); }
  // False beyond the grid.
  LIKENESS_HOST_DEVICE bool to_next_cell() {
    if (next[2] < smaller(next[0], next[1])) return advance(2);
    return next[0] < next[1] ? advance(0) : advance(1);
  }
  // From distance t to the cell after the brick: exact along the axis it is left by, inside the brick along
  // the others. Returns that distance; infinity beyond the grid.
  LIKENESS_HOST_DEVICE float to_next_brick(const int (&brick)[3], float t) {
    int axis = -1;
    float leave = INFINITY;
    for (int a = 0; a < 3; ++a) {
      if (!runs_along(a)) continue;
      const float out = (float((brick[a] + (direction[a] > 0)) * kBrick) - origin[a]) / direction[a];
      if (out < leave) leave = out, axis = a;
    }
    if (axis < 0) return INFINITY;
    t = larger(t, leave);
    for (int a = 0; a < 3; ++a) {
      const int first = brick[a] * kBrick, end = first + kBrick, last = (end < n ? end : n) - 1;
      cell[a] = a != axis          ? cell_at(origin[a] + t * direction[a], first, last)
                : direction[a] > 0 ? first + kBrick
                                   : first - 1;
      if (cell[a] < 0 || cell[a] >= n) return INFINITY;
      enter(a);
    }
    return t;
  }

 private:
  LIKENESS_HOST_DEVICE bool advance(int axis) {
    cell[axis] += step[axis];
    next[axis] += delta[axis];
    return cell[axis] >= 0 && cell[axis] < n;
  }
};

// Contents: is_empty(brick), at(cell) -> CellContent. resolution 0: all of the cube is occupied. visit(near,
// far, opacity) is called for every occupied cell and returns false to end the walk. Returns the distance at
// which the ray enters a core cell, or `far`.
template <class Contents, class Visit>
LIKENESS_HOST_DEVICE float walk_cells(const UnitRay& ray, int resolution, const Contents& contents,
                                      float near, float far, const Visit& visit) {
  const Interval inside = cube_interval(ray, near, far);
  if (inside.far <= inside.near) return far;
  if (resolution == 0) {
    visit(inside.near, inside.far, std::uint8_t(0));
    return far;
  }
  CellWalk walk(ray, resolution, inside.near);
  int known[3] = {-1, -1, -1};  // the brick the ray was in, which is not empty
  for (float t = inside.near; t < inside.far;) {
    const int brick[3] = {walk.cell[0] / kBrick, walk.cell[1] / kBrick, walk.cell[2] / kBrick};
    if (brick[0] != known[0] || brick[1] != known[1] || brick[2] != known[2]) {
      if (contents.is_empty(brick)) {
        t = walk.to_next_brick(brick, t);
        continue;
      }
      for (int a = 0; a < 3; ++a) known[a] = brick[a];
    }
    const CellContent found = contents.at(walk.cell);
    if (found.core) return t;
    const float leave = smaller(larger(walk.leaves_cell(), t), inside.far);
    if (found.occupied && leave > t && !visit(t, leave, found.opacity)) return far;
    t = leave;
    if (!walk.to_next_cell()) break;
  }
  return far;
}

// Whether a ray meets an occupied cell of either field, hidden by the other's core or not. walk(f, far,
// visit): through field f, as walk_cells. before: for each field, where its next walk may begin.
template <class Walk>
LIKENESS_HOST_DEVICE bool meets_cells(const Walk& walk, float far, float (&before)[2]) {
  before[0] = before[1] = 0;
  for (int f = 0; f < 2; ++f) {
    bool met = false;
    const auto note = [&](float t, float, std::uint8_t) {
      before[f] = t, met = true;
      return false;
    };
    far = smaller(far, walk(f, far, note));
    if (met) return true;
    before[f] = far;  // a field's core is found there again
  }
  return false;
}

}  // namespace likeness
