// Rays, occupancy walk (Amanatides & Woo 1987) and the placing of samples.
#include "core/render/rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace likeness {
namespace {

// splitmix64: one well-mixed number per (seed, index).
std::uint64_t mix(std::uint64_t v) {
  v += 0x9e3779b97f4a7c15ull;
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
  return v ^ (v >> 31);
}

float unit_float(std::uint64_t bits) { return float(bits >> 40) * 0x1p-24f; }

// Where the ray is inside the unit cube; near > far when it misses.
Interval cube_interval(const FieldRay& ray, float near, float far) {
  for (int a = 0; a < 3; ++a) {
    const float d = ray.direction[a], o = ray.origin[a];
    if (std::abs(d) < 1e-12f) {
      if (o < 0 || o > 1) return {1, 0};
      continue;
    }
    const float t0 = -o / d, t1 = (1 - o) / d;
    near = std::max(near, std::min(t0, t1));
    far = std::min(far, std::max(t0, t1));
  }
  return {near, far};
}

struct CellContent {
  bool occupied = false, core = false;
};

// The grid tells what the training poses showed in a cell; in another pose the neck that belongs there is
// looked up where it lies when straight.
CellContent content_of_neck(const NeckBend& neck, const OccupancyGrid& occupancy, const OccupancyGrid* core,
                            const int (&cell)[3]) {
  const int n = occupancy.resolution;
  const Vec3f centre = Vec3f(float(cell[0]) + 0.5f, float(cell[1]) + 0.5f, float(cell[2]) + 0.5f) / float(n);
  const Vec3f place = straightened(neck, centre) * float(n);
  int at[3];
  for (int a = 0; a < 3; ++a) {
    at[a] = int(std::floor(place[a]));
    if (at[a] < 0 || at[a] >= n) return {};
  }
  return {occupancy.occupied(cell[0], cell[1], cell[2]) || occupancy.occupied(at[0], at[1], at[2]),
          core && core->occupied(at[0], at[1], at[2])};
}

void append(std::vector<Interval>& intervals, std::size_t first, float near, float far) {
  if (far <= near) return;
  if (intervals.size() > first && near - intervals.back().far < 1e-6f)
    intervals.back().far = far;
  else
    intervals.push_back({near, far});
}

}  // namespace

UnitFromCamera unit_from_camera(const FieldCube& cube, const Pose& cam_from_world,
                                const Pose& world_from_field) {
  const Pose field_from_cam = (cam_from_world * world_from_field).inverse();
  UnitFromCamera map;
  map.linear = (field_from_cam.linear() / double(cube.side)).cast<float>();
  map.offset =
      ((field_from_cam.translation() - cube.origin.cast<double>()) / double(cube.side)).cast<float>();
  map.side = cube.side;
  return map;
}

FieldRay field_ray(const UnitFromCamera& map, const Vec3f& direction_in_cam) {
  return {map.offset, map.linear * direction_in_cam};
}

std::vector<Vec3f> pixel_directions(const Intrinsics& intrinsics) {
  const int width = intrinsics.width, height = intrinsics.height;
  std::vector<Vec3f> directions(std::size_t(width) * height);
  parallel_ranges(std::size_t(height), 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y)
      for (int x = 0; x < width; ++x)
        directions[y * width + x] =
            ray_direction(intrinsics, Vec2d(x + 0.5, double(y) + 0.5)).normalized().cast<float>();
  });
  return directions;
}

float occupied_intervals(const FieldRay& ray, const OccupancyGrid& occupancy, const OccupancyGrid& core,
                         float near, float far, std::vector<Interval>& intervals, const NeckBend* neck) {
  const std::size_t first = intervals.size();
  const Interval inside = cube_interval(ray, near, far);
  if (inside.far <= inside.near) return far;
  const int n = occupancy.resolution;
  if (n == 0) {
    append(intervals, first, inside.near, inside.far);
    return far;
  }
  // -- Walk the cells: next[a] is the distance at which the ray leaves its cell along axis a.
  const float scale = float(n);
  int cell[3], step[3];
  float next[3], delta[3];
  for (int a = 0; a < 3; ++a) {
    const float o = ray.origin[a] * scale, d = ray.direction[a] * scale;
    cell[a] = std::clamp(int(std::floor(o + inside.near * d)), 0, n - 1);
    step[a] = d > 0 ? 1 : -1;
    if (std::abs(d) < 1e-9f) {
      next[a] = delta[a] = std::numeric_limits<float>::infinity();
    } else {
      delta[a] = std::abs(1 / d);
      next[a] = (float(cell[a] + (d > 0)) - o) / d;
    }
  }
  const bool has_core = core.resolution == n;
  const bool bent = neck && !neck->straight;
  float t = inside.near;
  while (t < inside.far) {
    const CellContent content = bent && float(cell[1]) + 0.5f < neck->top * scale
                                    ? content_of_neck(*neck, occupancy, has_core ? &core : nullptr, cell)
                                    : CellContent{occupancy.occupied(cell[0], cell[1], cell[2]),
                                                  has_core && core.occupied(cell[0], cell[1], cell[2])};
    if (content.core) return t;
    int axis = next[0] < next[1] ? 0 : 1;
    if (next[2] < next[axis]) axis = 2;
    const float leave = std::min(std::max(next[axis], t), inside.far);
    if (content.occupied) append(intervals, first, t, leave);
    t = leave;
    cell[axis] += step[axis];
    if (cell[axis] < 0 || cell[axis] >= n) break;
    next[axis] += delta[axis];
  }
  return far;
}

int place_samples(std::span<const Interval> head, std::span<const Interval> torso, float min_step,
                  std::uint64_t jitter, std::span<RaySample> samples) {
  float total = 0;
  for (const Interval& i : head) total += i.far - i.near;
  for (const Interval& i : torso) total += i.far - i.near;
  if (total <= 0 || samples.empty()) return 0;
  const int count = std::clamp(int(std::ceil(total / min_step)), 1, int(samples.size()));
  const float stride = total / float(count);

  std::span<const Interval> list = head;
  int field = 0;
  std::size_t index = 0;
  float passed = 0;  // length of the intervals before list[index]
  for (int k = 0; k < count; ++k) {
    const float u = jitter == 0 ? 0.5f : unit_float(mix(jitter + std::uint64_t(k)));
    const float s = (float(k) + u) * stride;
    while (true) {
      if (index == list.size()) {
        if (field == 1) break;
        list = torso, field = 1, index = 0;
        continue;
      }
      const float length = list[index].far - list[index].near;
      if (s < passed + length) break;
      passed += length;
      ++index;
    }
    if (index == list.size()) {  // rounding took the last sample past the end
      const bool on_torso = !torso.empty();
      samples[k] = {(on_torso ? torso.back() : head.back()).far, stride, on_torso ? 1 : 0};
    } else {
      samples[k] = {list[index].near + (s - passed), stride, field};
    }
  }
  std::sort(samples.begin(), samples.begin() + count,
            [](const RaySample& a, const RaySample& b) { return a.t < b.t; });
  return count;
}

void FieldSamples::resize(std::size_t count) {
  for (auto* v : {&x, &y, &z, &dx, &dy, &dz}) v->resize(count);
  view.resize(count);
}

FieldInputs FieldSamples::inputs(const float* conditions, const float* latents) const {
  FieldInputs in;
  in.count = count();
  in.x = x.data(), in.y = y.data(), in.z = z.data();
  in.dx = dx.data(), in.dy = dy.data(), in.dz = dz.data();
  in.view = view.data();
  in.conditions = conditions;
  in.latents = latents;
  return in;
}

MarchVolumes march_volumes(const FieldPart& head, const FieldPart* torso) {
  MarchVolumes volumes;
  volumes.fields[0] = {&head.occupancy, &head.core, head.cube.side};
  if (torso) volumes.fields[1] = {&torso->occupancy, &torso->core, torso->cube.side};
  return volumes;
}

namespace {

struct RayIntervals {
  std::vector<Interval> head, torso;

  // Nothing beyond a core cell of one field is seen in the other either.
  void walk(const RayRequest& ray, const MarchVolumes& volumes) {
    head.clear(), torso.clear();
    float far = volumes.far;
    std::vector<Interval>* lists[2] = {&head, &torso};
    for (int f = 0; f < 2; ++f) {
      const MarchVolumes::Volume& volume = volumes.fields[f];
      if (!volume.occupancy) continue;
      const NeckBend* neck = f == 0 && !volumes.necks.empty()
                                 ? &volumes.necks[std::size_t(ray.view) % volumes.necks.size()]
                                 : nullptr;
      far = std::min(far, occupied_intervals(ray.fields[f], *volume.occupancy, *volume.core, volumes.near,
                                             far, *lists[f], neck));
    }
    if (far >= volumes.far) return;
    while (!head.empty() && head.back().near >= far) head.pop_back();
    if (!head.empty()) head.back().far = std::min(head.back().far, far);
  }
};

}  // namespace

bool meets_volume(const RayRequest& ray, const MarchVolumes& volumes) {
  static thread_local RayIntervals intervals;
  intervals.walk(ray, volumes);
  return !intervals.head.empty() || !intervals.torso.empty();
}

void sample_rays(std::span<const RayRequest> rays, const MarchVolumes& volumes, SampleBatch& batch) {
  const int most = volumes.max_samples;
  LIKENESS_CHECK(most > 0, "max_samples %d", most);
  std::vector<RaySample>& samples = batch.placed;
  samples.resize(rays.size() * most);
  std::vector<std::array<std::uint32_t, 2>> counts(rays.size());  // per ray: head, torso

  parallel_ranges(rays.size(), 256, [&](std::size_t first, std::size_t last) {
    RayIntervals intervals;
    for (std::size_t r = first; r < last; ++r) {
      intervals.walk(rays[r], volumes);
      const std::span<RaySample> mine(samples.data() + r * most, std::size_t(most));
      const int n = place_samples(intervals.head, intervals.torso, volumes.min_step, rays[r].jitter, mine);
      counts[r] = {0, 0};
      for (int k = 0; k < n; ++k) ++counts[r][mine[k].field];
    }
  });

  // -- Offsets, then each ray fills its own places.
  batch.begin.resize(rays.size() + 1);
  std::vector<std::array<std::uint32_t, 2>> offsets(rays.size() + 1);
  offsets[0] = {0, 0};
  for (std::size_t r = 0; r < rays.size(); ++r) {
    batch.begin[r] = offsets[r][0] + offsets[r][1];
    offsets[r + 1] = {offsets[r][0] + counts[r][0], offsets[r][1] + counts[r][1]};
  }
  const std::size_t total = std::size_t(offsets.back()[0]) + offsets.back()[1];
  batch.begin[rays.size()] = std::uint32_t(total);
  batch.dt.resize(total), batch.field.resize(total), batch.slot.resize(total);
  for (int f = 0; f < 2; ++f) batch.fields[f].resize(offsets.back()[f]);

  parallel_ranges(rays.size(), 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t r = first; r < last; ++r) {
      std::array<std::uint32_t, 2> slot = offsets[r];
      for (std::size_t i = batch.begin[r], k = r * most; i < batch.begin[r + 1]; ++i, ++k) {
        const RaySample& s = samples[k];
        const FieldRay& ray = rays[r].fields[s.field];
        const float side = volumes.fields[s.field].side;
        FieldSamples& out = batch.fields[s.field];
        const std::uint32_t at = slot[s.field]++;
        const Vec3f p = (ray.origin + s.t * ray.direction).cwiseMax(0.f).cwiseMin(1.f);
        const Vec3f d = ray.direction * side;
        out.x[at] = p.x(), out.y[at] = p.y(), out.z[at] = p.z();
        out.dx[at] = d.x(), out.dy[at] = d.y(), out.dz[at] = d.z();
        out.view[at] = rays[r].view;
        batch.dt[i] = s.dt / side;
        batch.field[i] = std::uint8_t(s.field);
        batch.slot[i] = at;
      }
    }
  });
}

}  // namespace likeness
