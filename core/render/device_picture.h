// Pictures on a device: from samples on rays to the fields' batches, and from the fields' outputs to pixels.
// Plain C++17. Arguments and layout as in device_march.h.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/render/device_march.h"

namespace likeness {

// Calls visit(k) for the samples of a ray in depth order; visit returns false to stop. t: of the ray's
// samples, the first `head` of `all` of them the head's.
template <class Visit>
LIKENESS_HOST_DEVICE void in_depth_order(const float* t, int head, int all, const Visit& visit) {
  int h = 0, s = head;
  while (h < head || s < all) {
    const bool from_head = s == all || (h < head && t[h] <= t[s]);
    if (!visit(from_head ? h++ : s++)) return;
  }
}

struct RayRow {
  std::size_t first;  // of the ray's samples in PlacedRays::t
  int head, all;
  LIKENESS_HOST_DEVICE RayRow(const PlacedRays& rays, std::size_t r)
      : first(r * std::size_t(rays.most)),
        head(int(rays.count[r])),
        all(head + int(rays.count[rays.rays + r])) {}
};

// Where sample k of ray r lies in its field's batch.
struct SampleSlot {
  int field;
  std::size_t slot;
  LIKENESS_HOST_DEVICE SampleSlot(const PlacedRays& rays, const std::uint32_t* offset, std::size_t r,
                                  const RayRow& row, int k)
      : field(k < row.head ? 0 : 1),
        slot(offset[std::size_t(field) * rays.rays + r] + std::size_t(field == 0 ? k : k - row.head)) {}
};

// *at += value; returns the old value.
LIKENESS_HOST_DEVICE inline std::uint32_t add_count(std::uint32_t* at, std::uint32_t value) {
#ifdef __CUDA_ARCH__
  return atomicAdd(at, value);
#else
  const std::uint32_t before = *at;
  *at += value;
  return before;
#endif
}

// By the threads of one block: sums along rows of kScanRays numbers. sums, next: (rows, kScanRays); returns
// the one with the result.
template <class Block>
LIKENESS_HOST_DEVICE std::uint32_t* prefix_sums(Block& block, int rows, std::uint32_t* sums,
                                                std::uint32_t* next) {
  for (int step = 1; step < kScanRays; step *= 2) {
    block.for_each(rows * kScanRays, [&](int item) {
      next[item] = sums[item] + (item % kScanRays >= step ? sums[item - step] : 0u);
    });
    std::uint32_t* const done = next;
    next = sums, sums = done;
  }
  return sums;
}

// Samples of ray r in field f; none beyond the last ray.
LIKENESS_HOST_DEVICE inline std::uint32_t count_of(const PlacedRays& rays, std::size_t r, int f) {
  return r < rays.rays ? rays.count[std::size_t(f) * rays.rays + r] : 0u;
}

// By the threads of one block, for kScanRays rays: a prefix sum among them, offset by what other blocks have
// taken. shared: (7, kScanRays).
template <class Block>
LIKENESS_HOST_DEVICE void ray_offsets(Block& block, const RayOffsetsArgs& a, std::uint32_t* shared) {
  const std::size_t first = std::size_t(block.index()) * kScanRays;
  std::uint32_t* const base = shared + 6 * kScanRays;
  const auto own = [&](int i, int f) { return count_of(a.rays, first + std::size_t(i), f); };
  block.for_each(kScanRays, [&](int i) {
    const std::uint32_t head = own(i, 0), torso = own(i, 1);
    shared[i] = head, shared[kScanRays + i] = torso, shared[2 * kScanRays + i] = head + torso > 0 ? 1u : 0u;
  });
  const std::uint32_t* const sums = prefix_sums(block, 3, shared, shared + 3 * kScanRays);
  block.for_each(3, [&](int row) {
    const std::uint32_t sum = sums[row * kScanRays + kScanRays - 1];
    if (row < 2) {
      base[row] = add_count(a.total[row], sum);
      add_count(a.samples, sum);
    } else {
      add_count(a.met, sum);
    }
  });
  block.for_each(kScanRays, [&](int i) {
    const std::size_t r = first + std::size_t(i);
    if (r >= a.rays.rays) return;
    for (int f = 0; f < 2; ++f)
      a.offset[std::size_t(f) * a.rays.rays + r] = base[f] + sums[f * kScanRays + i] - own(i, f);
  });
}

// A point of the head's unit cube to the resting face and the straight neck.
LIKENESS_HOST_DEVICE inline void head_to_canonical(const MarchScene& scene, const FrameNumbers& frame,
                                                   float (&p)[3]) {
  const auto* behind = reinterpret_cast<const unsigned char*>(&frame);
  if (frame.lattice.nodes[0] > 0) {
    float place[3], way[3];
    for (int a = 0; a < 3; ++a) place[a] = scene.grid[0].origin[a] + scene.grid[0].side * p[a];
    lattice_way(frame.lattice, reinterpret_cast<const LatticeColumn*>(behind + frame.columns_at),
                reinterpret_cast<const std::int16_t*>(behind + frame.rows_at), place, way);
    for (int a = 0; a < 3; ++a) p[a] = within(p[a] + way[a] / scene.grid[0].side, 0.f, 1.f);
  }
  straighten(frame.neck, p);
  for (int a = 0; a < 3; ++a) p[a] = within(p[a], 0.f, 1.f);
}

LIKENESS_HOST_DEVICE inline void torso_to_canonical(const MarchScene& scene, const FrameNumbers& frame,
                                                    float (&p)[3]) {
  const auto* behind = reinterpret_cast<const unsigned char*>(&frame);
  const MarchGrid& grid = scene.grid[1];
  float place[3], way[2];
  for (int a = 0; a < 3; ++a) place[a] = grid.origin[a] + grid.side * p[a];
  torso_way(frame.torso, reinterpret_cast<const float*>(behind + frame.displacement_at), place, way);
  for (int a = 0; a < 2; ++a) p[a] = within(p[a] + way[a] / grid.side, 0.f, 1.f);
}

// Maps a place on a ray to its field's canonical space; sets the position and direction of a field's sample.
LIKENESS_HOST_DEVICE inline void set_sample(const MarchScene& scene, const FrameNumbers& frame, int field,
                                            const float* direction, float t, float* const (&point)[6],
                                            std::size_t slot) {
  const UnitRay ray = unit_ray(frame, field, direction);
  float p[3];
  for (int c = 0; c < 3; ++c) p[c] = within(ray.origin[c] + t * ray.direction[c], 0.f, 1.f);
  field == 0 ? head_to_canonical(scene, frame, p) : torso_to_canonical(scene, frame, p);
  for (int c = 0; c < 3; ++c) {
    point[c][slot] = p[c];
    point[3 + c][slot] = ray.direction[c] * scene.grid[field].side;
  }
}

LIKENESS_HOST_DEVICE inline void gather_sample(const GatherArgs& a, std::size_t item) {
  const std::size_t r = item / std::size_t(a.rays.most);
  const int k = int(item % std::size_t(a.rays.most));
  const RayRow row(a.rays, r);
  if (k >= row.all) return;
  const SampleSlot at(a.rays, a.offset, r, row, k);
  set_sample(a.scene, *a.scene.frame, at.field, a.direction + 3 * r, a.rays.t[row.first + std::size_t(k)],
             a.point[at.field], at.slot);
}

LIKENESS_HOST_DEVICE inline void refine_strata(const RefineArgs& a, std::size_t r) {
  const RayRow row(a.strata, r);
  int count[2] = {0, 0};
  if (row.all == 0) return set_counts(a.out, r, count);
  const float *t = a.strata.t + row.first, *dt = a.strata.dt + row.first;
  float* weights = a.weights + row.first;
  float transmittance = 1, lost = 0, total = 0;
  in_depth_order(t, row.head, row.all, [&](int k) {
    const SampleSlot at(a.strata, a.offset, r, row, k);
    const FieldAnswer& field = a.field[at.field];
    const float after = transmittance * std::exp(-field.sigma[at.slot] * (dt[k] / field.side));
    weights[k] = transmittance - after;
    lost += weights[k], total += dt[k];
    transmittance = after;
    return true;
  });
  // -- Each one's mass by its neighbours in depth, as soon as the next one's weight is known.
  int last = -1;
  float before = 0, own = 0, blurred = 0;
  const auto finish = [&](float after) {
    if (last < 0) return;
    weights[last] = blurred_weight(before, own, after);
    blurred += weights[last];
  };
  in_depth_order(t, row.head, row.all, [&](int k) {
    const float weight = weights[k];
    finish(weight);
    before = own, own = weight, last = k;
    return true;
  });
  finish(0);
  // -- The strata lie in the order of the lists.
  const RefineShares shares(lost, blurred, row.all);
  RayLists lists(a.lists, r);
  for (int f = 0; f < 2; ++f) lists.counts[f] = int(a.lists.count[std::size_t(f) * a.lists.lanes + r]);
  Placing<RayLists> placing(lists);
  const auto segment = [&](int i) { return LengthAndMass{dt[i], shares.scale * weights[i] + shares.even}; };
  const std::size_t first = r * std::size_t(a.out.most);
  cut_evenly(row.all, segment, total, a.out.most, [&](int k, float from, float to) {
    const RaySample sample = placing.at(0.5f * (from + to));
    a.out.t[first + std::size_t(k)] = sample.t, a.out.dt[first + std::size_t(k)] = to - from;
    ++count[sample.field];
  });
  set_counts(a.out, r, count);
}

LIKENESS_HOST_DEVICE inline bool met_volume(const PlacedRays& rays, std::uint32_t r) {
  return rays.count[r] + rays.count[rays.rays + r] > 0;
}

// Whether a block beside this one, or across, met a volume.
LIKENESS_HOST_DEVICE inline bool near_volume(const PickArgs& a, std::uint32_t block) {
  const BlockPlace place = a.place[block];
  const int own = int(block - place.first), row = own / place.columns, column = own % place.columns;
  for (int y = row > 0 ? row - 1 : 0; y <= row + 1 && y < place.rows; ++y)
    for (int x = column > 0 ? column - 1 : 0; x <= column + 1 && x < place.columns; ++x)
      if (met_volume(a.strata, place.first + std::uint32_t(y * place.columns + x))) return true;
  return false;
}

LIKENESS_HOST_DEVICE inline void pick_samples(const PickArgs& a, std::size_t pixel) {
  const std::uint32_t block = a.block[pixel];
  const RayRow from(a.refined, block);
  int count[2] = {0, 0};
  if (from.all == 0 && near_volume(a, block)) a.alone[add_count(a.alone_count, 1)] = std::uint32_t(pixel);
  const std::size_t to = pixel * std::size_t(a.out.most);
  for (int f = 0; f < 2; ++f) {
    const int begin = f == 0 ? 0 : from.head, end = f == 0 ? from.head : from.all;
    if (begin == end) continue;
    const UnitRay ray = unit_ray(*a.scene.frame, f, a.direction + 3 * pixel);
    const GridContents contents(a.scene, *a.scene.frame, a.scene.neck_cells, f);
    const int n = a.scene.grid[f].resolution;
    for (int k = begin; k < end; ++k) {
      const float t = a.refined.t[from.first + std::size_t(k)],
                  dt = a.refined.dt[from.first + std::size_t(k)];
      int cell[3];
      bool inside = dt > 0;
      for (int c = 0; c < 3; ++c) {
        const float p = ray.origin[c] + t * ray.direction[c];
        inside = inside && p >= 0 && p < 1;
        cell[c] = int(p * float(n));
        if (cell[c] >= n) cell[c] = n - 1;
      }
      if (!inside || (n > 0 && !contents.at(cell).occupied)) continue;
      const std::size_t at = to + std::size_t(count[0] + count[1]);
      a.out.t[at] = t, a.out.dt[at] = dt;
      ++count[f];
    }
  }
  set_counts(a.out, pixel, count);
}

LIKENESS_HOST_DEVICE inline void composite_pixel(const CompositeArgs& a, std::size_t pixel) {
  const RayRow row(a.rays, pixel);
  float colour[3] = {0, 0, 0}, transmittance = 1, shaded = 0;
  in_depth_order(a.rays.t + row.first, row.head, row.all, [&](int k) {
    const SampleSlot at(a.rays, a.offset, pixel, row, k);
    const FieldAnswer& field = a.field[at.field];
    const float depth = a.rays.dt[row.first + std::size_t(k)] / field.side;
    const float after = transmittance * std::exp(-field.sigma[at.slot] * depth);
    const float weight = transmittance - after;
    transmittance = after;
    if (weight >= a.shade_weight) {
      for (int c = 0; c < 3; ++c)
        colour[c] += weight * field.colour[std::size_t(c) * field.capacity + at.slot];
      shaded += weight;
    }
    return after >= a.stop_transmittance;
  });
  // A ray that was cut off would have met more; it counts as opaque. Samples not looked up are given the mean
  // colour of those that were.
  const float alpha = transmittance < a.stop_transmittance ? 1 : 1 - transmittance;
  const float scale = shaded > 0 ? alpha / shaded : 0;
  float* to = a.rgba + 4 * std::size_t(a.place[pixel]);
  for (int c = 0; c < 3; ++c) to[c] = scale * colour[c];
  to[3] = alpha;
}

}  // namespace likeness
