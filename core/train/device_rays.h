// A training's rays on a device: the kernels' arguments and work, from the choice of a pixel to the samples
// of the fields' batches, and the look-ups of the grids' cells. Plain C++17: the choice, the walk and the
// cuts are those of ray_choice.h, march_math.h and strata_math.h, the same headers for processor and device.
//
// A step's samples take the places in the fields' batches that they take on the processor, ray after ray, so
// that random numbers drawn by a sample's place are also the same.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/camera/lens_math.h"
#include "core/field/device_kernels.h"
#include "core/render/device_march.h"
#include "core/render/device_picture.h"
#include "core/train/cell_math.h"
#include "core/train/mosaic_place.h"
#include "core/train/ray_choice.h"

namespace likeness {

// A training picture.
struct RayView {
  LensNumbers lens;
  std::int32_t width, height;
  PixelBox face;
  float gain[3];
  std::int32_t further, has_alpha;
  std::int32_t alone;    // the field that is learnt by it alone, or -1
  std::int64_t plate;    // its first pixel, or -1: there is none
  MosaicPlace mosaic;    // of width 0: the plate is what the view sees
  std::int64_t teaches;  // the first of its bits, or -1: everywhere
  std::uint64_t pixels;  // its first pixel
  std::uint64_t frame;   // bytes, of its FrameNumbers
};

struct RayViews {
  const RayView* view;  // (count)
  // Red, green, blue from the lowest byte, and above them the matte, or for a plate 255 where it was seen.
  const std::uint32_t* pixels;
  const std::uint8_t* teaches;  // bits
  unsigned char* frames;
  std::uint32_t count;
  // (count, neck_room, 2) contents of the cells in the necks' boxes, as MarchScene::neck_cells; a box with
  // more cells is not looked up here. 0: there are none.
  std::uint8_t* neck_cells;
  std::uint32_t neck_room;
};

// The rays of a step.
struct CastRays {
  float* direction;       // (rays, 3) unit, camera frame
  float* from;            // (rays, 2) as MarchedRay::from
  std::uint64_t* jitter;  // (rays)
  std::int32_t* row;      // (rays) of conditions
  std::uint32_t rays;
};

// Items: rays.
struct ChooseRaysArgs {
  MarchScene scene;
  RayViews views;
  ChoiceNumbers numbers;      // except the step
  const std::uint64_t* step;  // one number
  CastRays rays;
  float *target, *background;  // (rays, 3)
};

// Items: lanes, which share the rays.
struct MarchChosenArgs {
  MarchScene scene;
  RayViews views;
  CastRays rays;
  ListMemory lists;
  float even_share;
  PlacedRays out;
};

// Items: rays. Places in the fields' batches in the order of the rays.
struct OrderedOffsetsArgs {
  PlacedRays rays;
  std::uint32_t* offset;    // (2, rays)
  std::uint32_t* begin;     // (rays + 1) as SampleBatch::begin
  std::uint32_t* total[2];  // set; null: there is no such field
  StepNumbers* numbers;     // counts are set, in the sums, too
  StepSums* sums;
};

// A grid's bits. n: cells per axis, 0: no grid.
struct CellBits {
  std::int32_t n;
  const std::uint8_t* bits;
};

// Items: rays times most. Maps samples to their fields' canonical space, and back to their rays.
struct GatherChosenArgs {
  MarchScene scene;
  RayViews views;
  CastRays rays;
  PlacedRays placed;
  const std::uint32_t *offset, *begin;
  std::uint64_t seed;
  const std::uint64_t* step;
  std::uint32_t own;      // views of the first clip
  CellBits still, sides;  // shuffle_conditions, drop_codes_on_new_sides
  float* point[2][6];     // of each field, (capacity): position, direction
  std::int32_t* row[2];   // (capacity)
  // As SampleBatch's, in depth order.
  float* dt;
  std::uint8_t* field;
  std::uint32_t* slot;
};

// -- Cells. density is kept of all cells of a grid, (z, y, x), 0 of those that are not allowed.

// Items: cells of a batch.
struct LookUpArgs {
  MarchScene scene;
  RayViews views;
  const std::uint32_t* cells;
  std::uint32_t first, count;  // of the batch
  std::int32_t field;
  std::uint64_t seed, step;
  float* point[6];
  std::int32_t* row;
  std::uint32_t* batch_count;  // set
};
struct DecayArgs {
  const std::uint32_t* cells;
  std::uint32_t first, count;
  const float* sigma;
  float* density;
};

// Items: bytes of the grid's bits.
struct CellBitsArgs {
  std::int32_t n;
  const float* density;
  const std::uint8_t *allowed, *kept;
  std::uint8_t *bits, *opacity;
};

// Items: bricks.
struct BricksArgs {
  std::int32_t n;
  const std::uint8_t *bits, *core;  // core: or null
  std::uint8_t* bricks;
};

// Of the bricks of one height, unit cube; none are left where low lies above high.
struct BrickLayer {
  float low[2], high[2];  // x, z
};
// Items: heights.
struct LayersArgs {
  std::int32_t n;
  const std::uint8_t* bricks;
  BrickLayer* layers;
};
// Items: views. The boxes of their necks.
struct NeckBoxArgs {
  std::int32_t n;
  const BrickLayer* layers;
  RayViews views;
};
// Items: views times neck_room. What the boxes hold.
struct FillNecksArgs {
  MarchGrid head;
  RayViews views;
};

// -- Rays

LIKENESS_HOST_DEVICE inline FrameNumbers& frame_of(const RayViews& views, std::size_t view) {
  return *reinterpret_cast<FrameNumbers*>(views.frames + views.view[view].frame);
}

// Contents of the box of a view's neck, or null: each cell must be looked up at its place on the straight
// neck.
LIKENESS_HOST_DEVICE inline std::uint8_t* neck_cells_of(const RayViews& views, std::size_t view,
                                                        const FrameNumbers& frame) {
  if (!frame.neck.bends || neck_cell_count(frame) > views.neck_room) return nullptr;
  return views.neck_cells + 2 * view * views.neck_room;
}

LIKENESS_HOST_DEVICE inline void fill_neck(const FillNecksArgs& a, std::size_t view, std::size_t i) {
  const FrameNumbers& frame = frame_of(a.views, view);
  std::uint8_t* const out = neck_cells_of(a.views, view, frame);
  if (out && i < neck_cell_count(frame)) neck_cell(a.head, frame, i, out);
}

// As ray_choice.h requires them.
struct DeviceViews {
  const ChooseRaysArgs& a;
  float direction[3] = {0, 0, 1}, from[2] = {0, 0};

  LIKENESS_HOST_DEVICE explicit DeviceViews(const ChooseRaysArgs& args) : a(args) {}
  LIKENESS_HOST_DEVICE const RayView& view(std::size_t v) const { return a.views.view[v]; }
  LIKENESS_HOST_DEVICE std::size_t index(std::size_t v, int x, int y) const {
    return std::size_t(y) * std::size_t(view(v).width) + std::size_t(x);
  }
  LIKENESS_HOST_DEVICE int width(std::size_t v) const { return view(v).width; }
  LIKENESS_HOST_DEVICE int height(std::size_t v) const { return view(v).height; }
  LIKENESS_HOST_DEVICE PixelBox face(std::size_t v) const { return view(v).face; }
  LIKENESS_HOST_DEVICE bool has_alpha(std::size_t v) const { return view(v).has_alpha != 0; }
  LIKENESS_HOST_DEVICE std::uint8_t alpha(std::size_t v, int x, int y) const {
    return std::uint8_t(a.views.pixels[view(v).pixels + index(v, x, y)] >> 24);
  }
  LIKENESS_HOST_DEVICE bool masked(std::size_t v) const { return view(v).teaches >= 0; }
  LIKENESS_HOST_DEVICE bool teaches(std::size_t v, int x, int y) const {
    return !masked(v) || bit_at(a.views.teaches, std::size_t(view(v).teaches) + index(v, x, y));
  }
  LIKENESS_HOST_DEVICE bool further(std::size_t v) const { return view(v).further != 0; }
  LIKENESS_HOST_DEVICE void in_avatars_light(std::uint32_t pixel, std::size_t v, float (&out)[3]) const {
    for (int c = 0; c < 3; ++c)
      out[c] = smaller(float(pixel >> (8 * c) & 255u) / 255.f * view(v).gain[c], 1.f);
  }
  LIKENESS_HOST_DEVICE void colour(std::size_t v, int x, int y, float (&out)[3]) const {
    in_avatars_light(a.views.pixels[view(v).pixels + index(v, x, y)], v, out);
  }
  // A guessed plate is not used as background: there the matte separates the person, as without a plate.
  LIKENESS_HOST_DEVICE bool plate(std::size_t v, int x, int y, float (&out)[3]) const {
    if (view(v).plate < 0) return false;
    if (const MosaicPlace& mosaic = view(v).mosaic; mosaic.width > 0) {
      bool seen = false;
      const std::uint32_t* first = a.views.pixels + view(v).plate;
      const auto fetch = [&](int u, int w) {
        return first[std::size_t(w) * std::size_t(mosaic.width) + std::size_t(u)];
      };
      mosaic_colour(mosaic, x, y, fetch, out, seen);
      for (int c = 0; c < 3; ++c) out[c] = smaller(out[c] * view(v).gain[c], 1.f);
      return seen || !has_alpha(v);
    }
    const std::uint32_t pixel = a.views.pixels[std::size_t(view(v).plate) + index(v, x, y)];
    if (has_alpha(v) && pixel >> 24 != 255) return false;
    in_avatars_light(pixel, v, out);
    return true;
  }
  LIKENESS_HOST_DEVICE bool meets(std::size_t v, int x, int y) {
    double u, w;
    undistorted(view(v).lens, x + 0.5, y + 0.5, u, w);
    const double length = sqrt(u * u + w * w + 1);
    direction[0] = float(u / length), direction[1] = float(w / length), direction[2] = float(1 / length);
    const FrameNumbers& frame = frame_of(a.views, v);
    const int alone = view(v).alone;
    const auto walk = [&](int f, float far, const auto& visit) {
      if (!a.scene.grid[f].there || (alone >= 0 && f != alone)) return far;
      return walk_cells(unit_ray(frame, f, direction), a.scene.grid[f].resolution,
                        GridContents(a.scene, frame, neck_cells_of(a.views, v, frame), f), a.scene.near, far,
                        visit);
    };
    const bool met = meets_cells(walk, a.scene.far, from);
    if (alone >= 0) from[1 - alone] = INFINITY;
    return met;
  }
};

LIKENESS_HOST_DEVICE inline ChoiceNumbers numbers_of_step(const ChooseRaysArgs& a) {
  ChoiceNumbers numbers = a.numbers;
  numbers.step = *a.step;
  return numbers;
}

LIKENESS_HOST_DEVICE inline void set_chosen(const ChooseRaysArgs& a, std::size_t r, const DeviceViews& views,
                                            const ChosenRay& ray) {
  for (int c = 0; c < 3; ++c) {
    a.rays.direction[3 * r + std::size_t(c)] = views.direction[c];
    a.target[3 * r + std::size_t(c)] = ray.target[c];
    a.background[3 * r + std::size_t(c)] = ray.background[c];
  }
  for (int f = 0; f < 2; ++f) a.rays.from[2 * r + std::size_t(f)] = ray.nowhere ? INFINITY : views.from[f];
  a.rays.jitter[r] = ray.jitter, a.rays.row[r] = ray.view;
}

LIKENESS_HOST_DEVICE inline void choose_ray_of_step(const ChooseRaysArgs& a, std::size_t r) {
  DeviceViews views(a);
  set_chosen(a, r, views, choose_ray(views, numbers_of_step(a), r));
}

LIKENESS_HOST_DEVICE inline std::size_t view_of_ray(const RayViews& views, const CastRays& rays,
                                                    std::size_t r) {
  return std::size_t(rays.row[r]) % views.count;
}

LIKENESS_HOST_DEVICE inline void march_chosen(const MarchChosenArgs& a, std::size_t lane) {
  for (std::size_t r = lane; r < a.out.rays; r += a.lists.lanes) {
    RayLists lists(a.lists, lane);
    const MarchedRay ray{a.rays.direction + 3 * r,
                         {a.rays.from[2 * r], a.rays.from[2 * r + 1]},
                         a.rays.jitter[r],
                         a.even_share};
    const std::size_t view = view_of_ray(a.views, a.rays, r);
    const FrameNumbers& frame = frame_of(a.views, view);
    place_by_grids(a.scene, frame, neck_cells_of(a.views, view, frame), ray, lists, a.out, r);
  }
}

// By the threads of one block, for kScanRays rays: a prefix sum among them, offset by all earlier rays.
// shared: (8, kScanRays).
template <class Block>
LIKENESS_HOST_DEVICE void ordered_offsets(Block& block, const OrderedOffsetsArgs& a, std::uint32_t* shared) {
  const std::size_t first = std::size_t(block.index()) * kScanRays;
  block.for_each(kScanRays, [&](int i) {
    for (int f = 0; f < 2; ++f) {
      shared[f * kScanRays + i] = count_of(a.rays, first + std::size_t(i), f);
      std::uint32_t before = 0;
      for (std::size_t r = std::size_t(i); r < first; r += kScanRays) before += count_of(a.rays, r, f);
      shared[(2 + f) * kScanRays + i] = before;
    }
  });
  const std::uint32_t* const sums = prefix_sums(block, 4, shared, shared + 4 * kScanRays);
  block.for_each(kScanRays, [&](int i) {
    const std::size_t r = first + std::size_t(i);
    if (r >= a.rays.rays) return;
    std::uint32_t begin = 0, end = 0;
    for (int f = 0; f < 2; ++f) {
      const std::uint32_t next = sums[(3 + f) * kScanRays - 1] + sums[f * kScanRays + i],
                          own = next - count_of(a.rays, r, f);
      a.offset[std::size_t(f) * a.rays.rays + r] = own;
      begin += own, end += next;
      if (r + 1 < a.rays.rays) continue;
      if (a.total[f]) *a.total[f] = next;
      a.numbers->count[f] = a.sums->count[f] = next;
    }
    a.begin[r] = begin;
    if (r + 1 == a.rays.rays) a.begin[r + 1] = end;
  });
}

LIKENESS_HOST_DEVICE inline void gather_chosen(const GatherChosenArgs& a, std::size_t item) {
  const std::size_t r = item / std::size_t(a.placed.most);
  const int k = int(item % std::size_t(a.placed.most));
  const RayRow row(a.placed, r);
  if (k >= row.all) return;
  const SampleSlot at(a.placed, a.offset, r, row, k);
  const float* const t = a.placed.t + row.first;
  float* const* point = a.point[at.field];
  set_sample(a.scene, frame_of(a.views, view_of_ray(a.views, a.rays, r)), at.field, a.rays.direction + 3 * r,
             t[k], a.point[at.field], at.slot);
  const auto held_by = [&](const CellBits& grid) {
    return bit_at(grid.bits, cell_of_place(grid.n, point[0][at.slot], point[1][at.slot], point[2][at.slot]));
  };
  std::int32_t of_conditions = a.rays.row[r];
  if (at.field == 0 && a.still.n > 0) {
    RandomStream random = stream_of_sample(a.seed ^ kStillStream, *a.step, at.slot);
    of_conditions = shuffled_row(of_conditions, a.views.count, a.own, held_by(a.still), random);
  }
  if (at.field == 0 && a.sides.n > 0) {
    RandomStream random = stream_of_sample(a.seed ^ kSideStream, *a.step, at.slot);
    of_conditions = row_on_side(of_conditions, a.views.count, a.own, held_by(a.sides), random);
  }
  a.row[at.field][at.slot] = of_conditions;
  // -- Its place among the ray's samples in depth order, counting the other field's before it.
  int before = at.field == 0 ? k : k - row.head;
  if (at.field == 0)
    for (int s = row.head; s < row.all && t[s] < t[k]; ++s) ++before;
  else
    for (int h = 0; h < row.head && t[h] <= t[k]; ++h) ++before;
  const std::size_t i = a.begin[r] + std::size_t(before);
  a.dt[i] = a.placed.dt[row.first + std::size_t(k)] / a.scene.grid[at.field].side;
  a.field[i] = std::uint8_t(at.field), a.slot[i] = std::uint32_t(at.slot);
}

// -- Cells

LIKENESS_HOST_DEVICE inline void look_up_cell(const LookUpArgs& a, std::size_t i) {
  const int n = a.scene.grid[a.field].resolution;
  CellSample look(a.cells[a.first + i], n, a.views.count, a.seed, a.step, a.first + i);
  const FrameNumbers& frame = frame_of(a.views, std::size_t(look.view));
  a.field == 0 ? head_to_canonical(a.scene, frame, look.place)
               : torso_to_canonical(a.scene, frame, look.place);
  for (int c = 0; c < 3; ++c) a.point[c][i] = look.place[c], a.point[3 + c][i] = 0;
  a.row[i] = look.view;
  if (i == 0) *a.batch_count = a.count;
}

LIKENESS_HOST_DEVICE inline void decay_cell(const DecayArgs& a, std::size_t i) {
  float& density = a.density[a.cells[a.first + i]];
  density = decayed_density(density, a.sigma[i]);
}

// As occupancy_bits and cell_opacities: a cell is occupied if it or a neighbour holds something.
LIKENESS_HOST_DEVICE inline bool near_dense_cell(const CellBitsArgs& a, int x, int y, int z) {
  const int n = a.n;
  for (int k = z > 0 ? z - 1 : 0; k <= z + 1 && k < n; ++k)
    for (int j = y > 0 ? y - 1 : 0; j <= y + 1 && j < n; ++j)
      for (int i = x > 0 ? x - 1 : 0; i <= x + 1 && i < n; ++i)
        if (a.density[(std::size_t(k) * std::size_t(n) + std::size_t(j)) * std::size_t(n) + std::size_t(i)] >
            kCellThreshold)
          return true;
  return false;
}

LIKENESS_HOST_DEVICE inline void set_cell_bits(const CellBitsArgs& a, std::size_t byte) {
  const auto n = std::size_t(a.n), all = n * n * n;
  std::uint8_t found = 0;
  for (std::size_t i = 8 * byte; i < 8 * byte + 8 && i < all; ++i) {
    const bool allowed = bit_at(a.allowed, i);
    a.opacity[i] = allowed ? cell_opacity(a.density[i], a.n) : std::uint8_t(0);
    if (allowed && (bit_at(a.kept, i) || near_dense_cell(a, int(i % n), int(i / n % n), int(i / n / n))))
      found = std::uint8_t(found | 1u << (i & 7));
  }
  a.bits[byte] = found;
}

LIKENESS_HOST_DEVICE inline void mark_brick(const BricksArgs& a, std::size_t i) {
  const int m = bricks_along(a.n),
            first[3] = {int(i) % m * kBrick, int(i) / m % m * kBrick, int(i) / (m * m) * kBrick};
  const auto end = [&](int axis) { return first[axis] + kBrick < a.n ? first[axis] + kBrick : a.n; };
  bool any = false;
  for (int z = first[2]; z < end(2) && !any; ++z)
    for (int y = first[1]; y < end(1) && !any; ++y)
      for (int x = first[0]; x < end(0) && !any; ++x) {
        const int cell[3] = {x, y, z};
        const std::size_t at = cell_index(a.n, cell);
        any = bit_at(a.bits, at) || (a.core && bit_at(a.core, at));
      }
  a.bricks[i] = any ? 1 : 0;
}

LIKENESS_HOST_DEVICE inline void bound_layer(const LayersArgs& a, std::size_t y) {
  const int m = bricks_along(a.n);
  const float size = float(kBrick) / float(a.n);
  int low[2] = {m, m}, high[2] = {-1, -1};
  for (int z = 0; z < m; ++z)
    for (int x = 0; x < m; ++x) {
      if (!a.bricks[(std::size_t(z) * std::size_t(m) + y) * std::size_t(m) + std::size_t(x)]) continue;
      const int at[2] = {x, z};
      for (int k = 0; k < 2; ++k) {
        low[k] = at[k] < low[k] ? at[k] : low[k];
        high[k] = at[k] > high[k] ? at[k] : high[k];
      }
    }
  for (int k = 0; k < 2; ++k)
    a.layers[y].low[k] = size * float(low[k]),
    a.layers[y].high[k] = size * float(low[k] < m ? high[k] + 1 : -1);
}

// The box around everything the grids hold below the neck's top, in this view's bend: march_neck and
// bound_neck of rays.h.
LIKENESS_HOST_DEVICE inline void bound_neck_of_view(const NeckBoxArgs& a, std::size_t view) {
  FrameNumbers& frame = frame_of(a.views, view);
  const NeckTable& neck = frame.neck;
  if (!neck.bends) return;
  const int m = bricks_along(a.n);
  const float n = float(a.n), size = float(kBrick) / n, margin = 0.25f * size, most = 1e30f;
  float low[3] = {most, most, most}, high[3] = {-most, -most, -most};
  for (int y = 0; y < m; ++y) {
    const BrickLayer layer = a.layers[y];
    if (layer.low[0] > layer.high[0] || size * float(y) >= neck.top) continue;
    for (int corner = 0; corner < 8; ++corner) {
      const float height = size * float(y) + (corner & 2 ? size : 0.f);
      float p[3] = {corner & 1 ? layer.high[0] : layer.low[0], smaller(height, neck.top),
                    corner & 4 ? layer.high[1] : layer.low[1]};
      bend_neck(neck, p);
      for (int c = 0; c < 3; ++c) low[c] = smaller(low[c], p[c]), high[c] = larger(high[c], p[c]);
    }
  }
  const bool empty = low[0] > high[0];
  for (int c = 0; c < 3; ++c) {
    frame.neck_low[c] = empty ? most : low[c] - margin;
    frame.neck_high[c] = empty ? -most : high[c] + margin;
    // Cells whose centre lies in the box, and on y below the top.
    const float begin = bounded(ceilf(frame.neck_low[c] * n - 0.5f), 0.f, n);
    float end = bounded(floorf(frame.neck_high[c] * n - 0.5f) + 1, begin, n);
    if (c == 1) end = smaller(end, ceilf(neck.top * n - 0.5f));
    frame.neck_first[c] = std::int32_t(begin);
    frame.neck_count[c] = empty || end <= begin ? 0 : std::int32_t(end - begin);
  }
}

}  // namespace likeness
