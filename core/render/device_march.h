// Pictures on a device: the kernels' arguments, and from a pixel's ray to its samples. Plain C++17: the walk
// and the cuts are those of rays.h and strata.h, the same header for processor and device.
//
// A band of a picture goes through these kernels. Rays of pixels and of blocks of pixels keep their samples
// in rows of `most`, the head's first, then the torso's, each in depth order; prefix sums say where a ray's
// samples lie among those of each field.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/render/march_math.h"
#include "core/scene/warp_math.h"

namespace likeness {

// What changes from frame to frame. One in the device's memory, followed by the tables of the lattice and of
// the torso.
struct FrameNumbers {
  float linear[2][9], offset[2][3];           // camera to unit cube (UnitFromCamera), row-major
  NeckTable neck;                             // of the head's unit cube
  float neck_low[3], neck_high[3];            // the box of MarchNeck, unit cube
  std::int32_t neck_first[3], neck_count[3];  // its cells
  LatticeTable lattice;
  TorsoTable torso;
  std::uint32_t columns_at, rows_at, displacement_at;  // bytes behind this struct
};

// A field's grids. Null pointers: no such grid.
struct MarchGrid {
  std::int32_t there;       // 0: no such field
  std::int32_t resolution;  // 0: all is occupied
  float origin[3], side;    // of the cube, m
  const std::uint8_t *bits, *core, *opacity, *bricks;
};

struct MarchScene {
  MarchGrid grid[2];
  const float* depth_of_opacity;  // (256)
  // Shared by all rays; in training each ray has its own.
  const FrameNumbers* frame;
  const std::uint8_t* neck_cells;  // (cells of the neck's box, 2): 1 occupied + 2 core; opacity; or null
  float near, far, min_step;       // m
};

// Stretches of as many simultaneous rays as there are lanes. Row i of lane l is at i * lanes + l.
struct ListMemory {
  float *near, *far, *depth;  // (rows of head and torso, lanes)
  std::uint32_t* count;       // (2, lanes)
  std::uint32_t lanes;
  std::int32_t head_rows;
};

struct PlacedRays {
  float *t, *dt;         // (rays, most) m
  std::uint32_t* count;  // (2, rays) of the head's and the torso's field
  std::uint32_t rays;
  std::int32_t most;
};

// Items: cells of the neck's box, as many as there are at most.
struct NeckCellsArgs {
  MarchScene scene;
  std::uint8_t* out;
};

// Items: rays. A block's strata.
struct MarchStrataArgs {
  MarchScene scene;
  ListMemory lists;        // a lane a ray
  const float* direction;  // (rays, 3) unit, camera frame
  PlacedRays out;
};

// Items: lanes, which share the rays. Samples by the grids alone.
struct MarchRaysArgs {
  MarchScene scene;
  ListMemory lists;
  const float* direction;
  const std::uint32_t *wanted, *wanted_count;  // those of the rays that are marched; or null: all
  PlacedRays out;
};

// Items: rays. Places in the fields' batches, which is how rays' samples are packed.
constexpr int kScanRays = 256;
struct RayOffsetsArgs {
  PlacedRays rays;
  std::uint32_t* offset;         // (2, rays)
  std::uint32_t* total[2];       // added to
  std::uint32_t *samples, *met;  // added to: samples; rays that have any
};

// Items: rays times most. Maps samples to their fields' canonical space.
struct GatherArgs {
  MarchScene scene;
  PlacedRays rays;
  const std::uint32_t* offset;
  const float* direction;
  float* point[2][6];  // of each field, (capacity): position, direction
};

// A field's outputs for its batch.
struct FieldAnswer {
  const float *sigma, *colour;  // (capacity); (3, capacity)
  std::uint32_t capacity;
  float side;  // m
};

// Items: rays of blocks. Their strata are refined by the light that is lost in them.
struct RefineArgs {
  ListMemory lists;
  PlacedRays strata;
  const std::uint32_t* offset;
  FieldAnswer field[2];
  float* weights;  // (rays, strata.most) work space
  PlacedRays out;
};

// A block among those of its tile of the picture.
struct BlockPlace {
  std::uint32_t first;  // of the tile
  std::int32_t columns, rows;
};

// Items: pixels. Those samples of their block that lie in occupied cells of their own ray.
struct PickArgs {
  MarchScene scene;
  const float* direction;      // (pixels, 3)
  const std::uint32_t* block;  // (pixels)
  const BlockPlace* place;     // (blocks)
  PlacedRays strata, refined, out;
  // (pixels) those whose block's ray met nothing although theirs may, and their number, initially 0.
  std::uint32_t *alone, *alone_count;
};

// Items: pixels.
struct CompositeArgs {
  PlacedRays rays;
  const std::uint32_t* offset;
  FieldAnswer field[2];
  const std::uint32_t* place;  // (pixels) in the picture
  float* rgba;                 // (picture's pixels, 4)
  float shade_weight, stop_transmittance;
};

// -- Grids

LIKENESS_HOST_DEVICE inline bool bit_at(const std::uint8_t* bits, std::size_t i) {
  return bits[i >> 3] >> (i & 7) & 1;
}
LIKENESS_HOST_DEVICE inline std::size_t cell_index(int n, const int (&cell)[3]) {
  return (std::size_t(cell[2]) * std::size_t(n) + std::size_t(cell[1])) * std::size_t(n) +
         std::size_t(cell[0]);
}

// A cell's own occupancy, the rest looked up at its place on the straight neck.
LIKENESS_HOST_DEVICE inline CellContent content_of_neck(const MarchGrid& grid, const NeckTable& neck,
                                                        const int (&cell)[3]) {
  const int n = grid.resolution;
  float place[3];
  for (int a = 0; a < 3; ++a) place[a] = (float(cell[a]) + 0.5f) / float(n);
  straighten(neck, place);
  int at[3];
  for (int a = 0; a < 3; ++a) {
    at[a] = int(floorf(place[a] * float(n)));
    if (at[a] < 0 || at[a] >= n) return {};
  }
  const std::size_t i = cell_index(n, at);
  return {bit_at(grid.bits, cell_index(n, cell)) || bit_at(grid.bits, i), grid.core && bit_at(grid.core, i),
          grid.opacity ? grid.opacity[i] : std::uint8_t(0)};
}

struct GridContents {
  const MarchGrid& grid;
  const FrameNumbers* frame;  // of a bent neck, or null
  const std::uint8_t* neck_cells;

  LIKENESS_HOST_DEVICE GridContents(const MarchScene& scene, const FrameNumbers& of,
                                    const std::uint8_t* cells, int field)
      : grid(scene.grid[field]), frame(field == 0 && of.neck.bends ? &of : nullptr), neck_cells(cells) {}
  LIKENESS_HOST_DEVICE bool is_empty(const int (&brick)[3]) const {
    const int m = bricks_along(grid.resolution);
    if (grid.bricks[(std::size_t(brick[2]) * m + brick[1]) * m + brick[0]]) return false;
    const float n = float(grid.resolution);
    if (!frame || float(brick[1] * kBrick) >= frame->neck.top * n) return true;
    for (int a = 0; a < 3; ++a)
      if (float((brick[a] + 1) * kBrick) < frame->neck_low[a] * n ||
          float(brick[a] * kBrick) > frame->neck_high[a] * n)
        return true;
    return false;
  }
  LIKENESS_HOST_DEVICE CellContent at(const int (&cell)[3]) const {
    const std::size_t own = cell_index(grid.resolution, cell);
    if (frame && float(cell[1]) + 0.5f < frame->neck.top * float(grid.resolution)) {
      std::size_t i = 0;
      for (int a = 2; a >= 0; --a) {
        const int in_box = cell[a] - frame->neck_first[a];
        if (in_box < 0 || in_box >= frame->neck_count[a])
          return bit_at(grid.bits, own) ? content_of_neck(grid, frame->neck, cell) : CellContent{};
        i = i * std::size_t(frame->neck_count[a]) + std::size_t(in_box);
      }
      if (!neck_cells) return content_of_neck(grid, frame->neck, cell);
      return {(neck_cells[2 * i] & 1) != 0, (neck_cells[2 * i] & 2) != 0, neck_cells[2 * i + 1]};
    }
    return {bit_at(grid.bits, own), grid.core && bit_at(grid.core, own),
            grid.opacity ? grid.opacity[own] : std::uint8_t(0)};
  }
};

LIKENESS_HOST_DEVICE inline std::size_t neck_cell_count(const FrameNumbers& frame) {
  return std::size_t(frame.neck_count[0]) * std::size_t(frame.neck_count[1]) *
         std::size_t(frame.neck_count[2]);
}

// Of the neck's box; out: as MarchScene::neck_cells.
LIKENESS_HOST_DEVICE inline void neck_cell(const MarchGrid& head, const FrameNumbers& frame, std::size_t i,
                                           std::uint8_t* out) {
  const std::size_t nx = std::size_t(frame.neck_count[0]), ny = std::size_t(frame.neck_count[1]);
  const int cell[3] = {frame.neck_first[0] + int(i % nx), frame.neck_first[1] + int(i / nx % ny),
                       frame.neck_first[2] + int(i / nx / ny)};
  const CellContent found = content_of_neck(head, frame.neck, cell);
  out[2 * i] = std::uint8_t((found.occupied ? 1 : 0) + (found.core ? 2 : 0));
  out[2 * i + 1] = found.opacity;
}
LIKENESS_HOST_DEVICE inline void fill_neck_cell(const NeckCellsArgs& a, std::size_t i) {
  neck_cell(a.scene.grid[0], *a.scene.frame, i, a.out);
}

// -- Stretches and the samples in them

LIKENESS_HOST_DEVICE inline UnitRay unit_ray(const FrameNumbers& frame, int field, const float* direction) {
  UnitRay ray;
  for (int a = 0; a < 3; ++a) {
    ray.origin[a] = frame.offset[field][a];
    ray.direction[a] = dot3(frame.linear[field] + 3 * a, direction);
  }
  return ray;
}

// The stretches of one ray; weights take the place of optical depths.
struct RayLists {
  const ListMemory& memory;
  std::size_t lane;
  int counts[2] = {0, 0};

  LIKENESS_HOST_DEVICE RayLists(const ListMemory& m, std::size_t l) : memory(m), lane(l) {}
  LIKENESS_HOST_DEVICE std::size_t at(int field, int i) const {
    return std::size_t(i + (field == 0 ? 0 : memory.head_rows)) * memory.lanes + lane;
  }
  LIKENESS_HOST_DEVICE std::size_t at(int i) const { return i < counts[0] ? at(0, i) : at(1, i - counts[0]); }
  LIKENESS_HOST_DEVICE int count(int field) const { return counts[field]; }
  LIKENESS_HOST_DEVICE Interval interval(int field, int i) const {
    const std::size_t k = at(field, i);
    return {memory.near[k], memory.far[k], memory.depth[k]};
  }
  LIKENESS_HOST_DEVICE void set(int field, int i, const Interval& value) {
    const std::size_t k = at(field, i);
    memory.near[k] = value.near, memory.far[k] = value.far, memory.depth[k] = value.depth;
  }
  LIKENESS_HOST_DEVICE float weight(int i) const { return memory.depth[at(i)]; }
  LIKENESS_HOST_DEVICE void set_weight(int i, float weight) { memory.depth[at(i)] = weight; }
  // Adjoining stretches without known depth are merged, as in occupied_intervals.
  LIKENESS_HOST_DEVICE void push(int field, const Interval& next) {
    if (next.far <= next.near) return;
    if (const int last = counts[field] - 1; last >= 0 && next.depth == 0) {
      const Interval before = interval(field, last);
      if (before.depth == 0 && next.near - before.far < 1e-6f) {
        memory.far[at(field, last)] = next.far;
        return;
      }
    }
    set(field, counts[field]++, next);
  }
};

// One ray: its direction, and how its samples are placed.
struct MarchedRay {
  const float* direction;    // (3) unit, camera frame
  float from[2] = {0, 0};    // m, for each field: where its walk may begin; infinite: not met
  std::uint64_t jitter = 0;  // as in place_samples
  float even_share = kEvenShare;
};

// Nothing beyond a core cell of one field is seen in the other either.
LIKENESS_HOST_DEVICE inline void walk_ray(const MarchScene& scene, const FrameNumbers& frame,
                                          const std::uint8_t* neck_cells, const MarchedRay& marched,
                                          RayLists& lists) {
  float far = scene.far;
  for (int f = 0; f < 2; ++f) {
    if (!scene.grid[f].there) continue;
    const UnitRay ray = unit_ray(frame, f, marched.direction);
    const int n = scene.grid[f].resolution;
    const float cells_per_m = float(n) * sqrtf(dot3(ray.direction, ray.direction));
    const auto visit = [&](float near, float leave, std::uint8_t opacity) {
      const float depth = opacity == 0 ? 0 : scene.depth_of_opacity[opacity] * (leave - near) * cells_per_m;
      lists.push(f, {near, leave, depth});
      return true;
    };
    const float near = larger(scene.near, marched.from[f]);
    far = smaller(far, walk_cells(ray, n, GridContents(scene, frame, neck_cells, f), near, far, visit));
  }
  if (far >= scene.far) return;
  while (lists.counts[0] > 0 && lists.interval(0, lists.counts[0] - 1).near >= far) --lists.counts[0];
  if (lists.counts[0] == 0) return;
  Interval last = lists.interval(0, lists.counts[0] - 1);
  if (last.far <= far) return;
  last.depth *= (far - last.near) / (last.far - last.near);
  last.far = far;
  lists.set(0, lists.counts[0] - 1, last);
}

LIKENESS_HOST_DEVICE inline void set_counts(const PlacedRays& rays, std::size_t r, const int (&count)[2]) {
  for (int f = 0; f < 2; ++f) rays.count[std::size_t(f) * rays.rays + r] = std::uint32_t(count[f]);
}

// Walks ray r and puts samples into its strata.
LIKENESS_HOST_DEVICE inline void place_by_grids(const MarchScene& scene, const FrameNumbers& frame,
                                                const std::uint8_t* neck_cells, const MarchedRay& ray,
                                                RayLists& lists, const PlacedRays& out, std::size_t r) {
  walk_ray(scene, frame, neck_cells, ray, lists);
  int count[2] = {0, 0};
  Placing<RayLists> placing(lists);
  const std::size_t row = r * std::size_t(out.most);
  cut_strata(lists, scene.min_step, ray.even_share, out.most, [&](int k, float from, float to) {
    const RaySample sample = placing.at(from + place_in_stratum(ray.jitter, k) * (to - from));
    out.t[row + std::size_t(k)] = sample.t, out.dt[row + std::size_t(k)] = to - from;
    ++count[sample.field];
  });
  set_counts(out, r, count);
}

LIKENESS_HOST_DEVICE inline void march_strata(const MarchStrataArgs& a, std::size_t r) {
  RayLists lists(a.lists, r);
  place_by_grids(a.scene, *a.scene.frame, a.scene.neck_cells, MarchedRay{a.direction + 3 * r}, lists, a.out,
                 r);
  for (int f = 0; f < 2; ++f)
    a.lists.count[std::size_t(f) * a.lists.lanes + r] = std::uint32_t(lists.counts[f]);
}

LIKENESS_HOST_DEVICE inline void march_rays(const MarchRaysArgs& a, std::size_t lane) {
  const std::size_t rays = a.wanted ? *a.wanted_count : a.out.rays;
  for (std::size_t i = lane; i < rays; i += a.lists.lanes) {
    const std::size_t r = a.wanted ? a.wanted[i] : i;
    RayLists lists(a.lists, lane);
    place_by_grids(a.scene, *a.scene.frame, a.scene.neck_cells, MarchedRay{a.direction + 3 * r}, lists, a.out,
                   r);
  }
}

}  // namespace likeness
