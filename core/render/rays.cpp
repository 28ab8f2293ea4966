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
  std::uint8_t opacity = 0;
};

std::size_t index_of(int n, const int (&cell)[3]) {
  return (std::size_t(cell[2]) * n + cell[1]) * n + cell[0];
}

// Optical depth of a cell's width by its opacity; that of the most opaque ones is open upwards.
const std::array<float, 256>& depth_of_opacity() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> depths{};
    for (int i = 0; i < 256; ++i) depths[std::size_t(i)] = float(-std::log(1 - std::min(i, 254) / 255.0));
    return depths;
  }();
  return table;
}

// The grid tells what the training poses showed in a cell; in another pose the neck that belongs there is
// looked up where it lies when straight.
CellContent content_of_neck(const NeckBend& neck, const MarchVolume& volume, const OccupancyGrid* core,
                            const int (&cell)[3]) {
  const int n = volume.occupancy->resolution;
  const Vec3f centre = Vec3f(float(cell[0]) + 0.5f, float(cell[1]) + 0.5f, float(cell[2]) + 0.5f) / float(n);
  const Vec3f place = straightened(neck, centre) * float(n);
  int at[3];
  for (int a = 0; a < 3; ++a) {
    at[a] = int(std::floor(place[a]));
    if (at[a] < 0 || at[a] >= n) return {};
  }
  return {volume.occupancy->occupied(cell[0], cell[1], cell[2]) ||
              volume.occupancy->occupied(at[0], at[1], at[2]),
          core && core->occupied(at[0], at[1], at[2]),
          volume.opacity.empty() ? std::uint8_t(0) : volume.opacity[index_of(n, at)]};
}

constexpr int kBrick = 8;  // cells: one byte of a grid's bits along x
int bricks_along(int n) { return (n + kBrick - 1) / kBrick; }

void mark_bricks(const OccupancyGrid& grid, std::vector<std::uint8_t>& bricks) {
  const int n = grid.resolution, m = bricks_along(n);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int b = 0; b < m; ++b) {
        bool any = false;
        if (n % kBrick == 0)
          any = grid.bits[(std::size_t(z) * n + y) * std::size_t(m) + b] != 0;
        else
          for (int x = b * kBrick; x < std::min(n, (b + 1) * kBrick); ++x)
            any = any || grid.occupied(x, y, z);
        if (any) bricks[(std::size_t(z / kBrick) * m + y / kBrick) * m + b] = 1;
      }
}

// A ray's way through cells, in units of cells.
struct CellWalk {
  float origin[3], direction[3];
  float next[3], delta[3];  // distance (m) at which the ray leaves its cell along an axis; between two such
  int cell[3], step[3], n = 0;

  CellWalk(const FieldRay& ray, int resolution, float near) : n(resolution) {
    for (int a = 0; a < 3; ++a) {
      origin[a] = ray.origin[a] * float(n), direction[a] = ray.direction[a] * float(n);
      cell[a] = std::clamp(int(std::floor(origin[a] + near * direction[a])), 0, n - 1);
      step[a] = direction[a] > 0 ? 1 : -1;
      enter(a);
    }
  }
  bool runs_along(int a) const { return std::abs(direction[a]) >= 1e-9f; }
  void enter(int a) {
    next[a] = delta[a] = std::numeric_limits<float>::infinity();
    if (!runs_along(a)) return;
    delta[a] = std::abs(1 / direction[a]);
    next[a] = (float(cell[a] + (direction[a] > 0)) - origin[a]) / direction[a];
  }
  float leaves_cell() const { return std::min({next[0], next[1], next[2]}); }
  // False beyond the grid.
  bool to_next_cell() {
    int axis = next[0] < next[1] ? 0 : 1;
    if (next[2] < next[axis]) axis = 2;
    cell[axis] += step[axis];
    next[axis] += delta[axis];
    return cell[axis] >= 0 && cell[axis] < n;
  }
  // From distance t to the cell behind the brick: exact along the axis it is left by, inside the brick along
  // the others. Returns that distance; infinity beyond the grid.
  float to_next_brick(const int (&brick)[3], float t) {
    constexpr float kNever = std::numeric_limits<float>::infinity();
    int axis = -1;
    float leave = kNever;
    for (int a = 0; a < 3; ++a) {
      if (!runs_along(a)) continue;
      const float out = (float((brick[a] + (direction[a] > 0)) * kBrick) - origin[a]) / direction[a];
      if (out < leave) leave = out, axis = a;
    }
    if (axis < 0) return kNever;
    t = std::max(t, leave);
    for (int a = 0; a < 3; ++a) {
      const int first = brick[a] * kBrick, last = std::min(n, first + kBrick) - 1;
      cell[a] = a != axis          ? std::clamp(int(std::floor(origin[a] + t * direction[a])), first, last)
                : direction[a] > 0 ? first + kBrick
                                   : first - 1;
      if (cell[a] < 0 || cell[a] >= n) return kNever;
      enter(a);
    }
    return t;
  }
};

// What cells and bricks hold, the neck bent.
struct CellContents {
  const MarchVolume& volume;
  const OccupancyGrid* core;  // or null
  const NeckBend* bend;       // null: nothing is bent
  float top = 0;              // of the neck, cells
  Eigen::AlignedBox3f box{};  // of what is bent, cells

  CellContents(const MarchVolume& v, const MarchNeck* neck) : volume(v), core(nullptr), bend(nullptr) {
    const int n = volume.occupancy->resolution;
    if (volume.core && volume.core->resolution == n) core = volume.core;
    if (!neck || neck->bend->straight) return;
    bend = neck->bend;
    top = bend->top * float(n);
    box = {neck->box.min() * float(n), neck->box.max() * float(n)};
  }
  bool is_empty(const int (&brick)[3]) const {
    if (volume.bricks.empty()) return false;
    const auto m = std::size_t(bricks_along(volume.occupancy->resolution));
    if (volume.bricks[(std::size_t(brick[2]) * m + std::size_t(brick[1])) * m + std::size_t(brick[0])])
      return false;
    if (!bend || float(brick[1] * kBrick) >= top) return true;
    for (int a = 0; a < 3; ++a)
      if (float((brick[a] + 1) * kBrick) < box.min()[a] || float(brick[a] * kBrick) > box.max()[a])
        return true;
    return false;
  }
  CellContent at(const int (&cell)[3]) const {
    const OccupancyGrid& occupancy = *volume.occupancy;
    const bool own = occupancy.occupied(cell[0], cell[1], cell[2]);
    if (bend && float(cell[1]) + 0.5f < top) {
      const Vec3f centre(float(cell[0]) + 0.5f, float(cell[1]) + 0.5f, float(cell[2]) + 0.5f);
      return own || box.contains(centre) ? content_of_neck(*bend, volume, core, cell) : CellContent{};
    }
    return {own, core && core->occupied(cell[0], cell[1], cell[2]),
            volume.opacity.empty() ? std::uint8_t(0) : volume.opacity[index_of(occupancy.resolution, cell)]};
  }
};

// The walk through the cells (Amanatides & Woo 1987), over empty bricks in one step. visit(near, far,
// opacity) is called for every occupied cell and ends the walk by false; returns as occupied_intervals.
template <class Visit>
float walk_cells(const FieldRay& ray, const MarchVolume& volume, const MarchNeck* neck, float near, float far,
                 const Visit& visit) {
  const Interval inside = cube_interval(ray, near, far);
  if (inside.far <= inside.near) return far;
  if (volume.occupancy->resolution == 0) {
    visit(inside.near, inside.far, std::uint8_t(0));
    return far;
  }
  const CellContents contents(volume, neck);
  CellWalk walk(ray, volume.occupancy->resolution, inside.near);
  int known[3] = {-1, -1, -1};  // the brick the ray was in, which is not empty
  for (float t = inside.near; t < inside.far;) {
    const int brick[3] = {walk.cell[0] / kBrick, walk.cell[1] / kBrick, walk.cell[2] / kBrick};
    if (!std::equal(brick, brick + 3, known)) {
      if (contents.is_empty(brick)) {
        t = walk.to_next_brick(brick, t);
        continue;
      }
      std::copy(brick, brick + 3, known);
    }
    const CellContent found = contents.at(walk.cell);
    if (found.core) return t;
    const float leave = std::min(std::max(walk.leaves_cell(), t), inside.far);
    if (found.occupied && leave > t && !visit(t, leave, found.opacity)) return far;
    t = leave;
    if (!walk.to_next_cell()) break;
  }
  return far;
}

void append(std::vector<Interval>& intervals, std::size_t first, const Interval& next) {
  if (next.far <= next.near) return;
  if (intervals.size() > first && next.near - intervals.back().far < 1e-6f && next.depth == 0 &&
      intervals.back().depth == 0)
    intervals.back().far = next.far;
  else
    intervals.push_back(next);
}

// Transmittance up to each interval times what it takes away, both lists in depth order; returns the sum.
float lost_light(std::span<const Interval> head, std::span<const Interval> torso, float* weights) {
  std::size_t h = 0, t = 0;
  float transmittance = 1;
  while (h < head.size() || t < torso.size()) {
    const bool from_head = t == torso.size() || (h < head.size() && head[h].near <= torso[t].near);
    const Interval& interval = from_head ? head[h] : torso[t];
    const float d = interval.depth;
    // exp(d) by its first terms: where the light goes need not be known better.
    const float after = transmittance / (1 + d * (1 + d * (0.5f + d * (1.f / 6 + d * (1.f / 24)))));
    weights[from_head ? h : head.size() + t] = transmittance - after;
    transmittance = after;
    from_head ? ++h : ++t;
  }
  return 1 - transmittance;
}

// Lengths along the two lists, asked for in rising order, to places on the ray.
struct Placing {
  std::span<const Interval> list, next;
  std::size_t index = 0;
  float passed = 0;  // length of the intervals before list[index]
  int field = 0;

  RaySample at(float length) {
    while (true) {
      if (index == list.size()) {
        if (field == 1 || next.empty()) break;
        list = next, field = 1, index = 0;
        continue;
      }
      const float own = list[index].far - list[index].near;
      if (length < passed + own) return {list[index].near + (length - passed), 0, field};
      passed += own;
      ++index;
    }
    return {list.back().far, 0, field};  // rounding went past the end
  }
};

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

MarchVolume march_volume(const OccupancyGrid& occupancy, const OccupancyGrid& core, float side,
                         std::span<const std::uint8_t> opacity) {
  MarchVolume volume{&occupancy, &core, side, opacity, {}};
  const int n = occupancy.resolution, m = bricks_along(n);
  if (n == 0) return volume;
  volume.bricks.assign(std::size_t(m) * m * m, 0);
  mark_bricks(occupancy, volume.bricks);
  if (core.resolution == n) mark_bricks(core, volume.bricks);
  const float size = float(kBrick) / float(n);
  volume.layers.resize(std::size_t(m));
  for (int z = 0; z < m; ++z)
    for (int y = 0; y < m; ++y)
      for (int x = 0; x < m; ++x)
        if (volume.bricks[(std::size_t(z) * m + y) * m + x]) {
          const Vec3f low = size * Vec3f(float(x), float(y), float(z));
          volume.layers[std::size_t(y)].extend(low).extend(low + Vec3f::Constant(size));
        }
  return volume;
}

MarchNeck march_neck(const NeckBend& bend, const MarchVolume& head) {
  MarchNeck neck{&bend, {}};
  if (bend.straight) return neck;
  float margin = 0;
  for (const Eigen::AlignedBox3f& layer : head.layers) {
    if (layer.isEmpty() || layer.min().y() >= bend.top) continue;
    margin = 0.25f * layer.sizes().y();  // what lies within bends less evenly than the corners do
    for (int corner = 0; corner < 8; ++corner) {
      Vec3f at = layer.corner(Eigen::AlignedBox3f::CornerType(corner));
      at.y() = std::min(at.y(), bend.top);
      neck.box.extend(bent(bend, at));
    }
  }
  if (!neck.box.isEmpty()) neck.box.min().array() -= margin, neck.box.max().array() += margin;
  return neck;
}

float occupied_intervals(const FieldRay& ray, const MarchVolume& volume, float near, float far,
                         std::vector<Interval>& intervals, const MarchNeck* neck) {
  const std::size_t first = intervals.size();
  const float cells_per_m = float(volume.occupancy->resolution) * ray.direction.norm();
  return walk_cells(ray, volume, neck, near, far, [&](float t, float leave, std::uint8_t opacity) {
    const float depth = opacity == 0 ? 0 : depth_of_opacity()[opacity] * (leave - t) * cells_per_m;
    append(intervals, first, {t, leave, depth});
    return true;
  });
}

int place_samples(std::span<const Interval> head, std::span<const Interval> torso, float min_step,
                  std::uint64_t jitter, std::span<RaySample> samples) {
  float total = 0, known = 0;
  for (const std::span<const Interval> list : {head, torso})
    for (const Interval& i : list) total += i.far - i.near, known += i.depth;
  if (total <= 0 || samples.empty()) return 0;
  const int count = std::clamp(int(std::ceil(total / min_step)), 1, int(samples.size()));
  static thread_local std::vector<float> weights;  // of the lists' intervals, head first; sum: what is lost
  weights.assign(head.size() + torso.size(), 0.f);
  const float lost = known > 0 ? lost_light(head, torso, weights.data()) : 0;
  const float even = (1 - (1 - kEvenShare) * lost) / total;  // share of the samples per m

  // -- Where stratum k ends: mass (k + 1) / count of the samples passed, and so much length.
  std::size_t index = 0;
  float mass = 0, passed = 0, start = 0;  // before interval `index`; start: of stratum k, m of length
  Placing placing{head, torso};
  for (int k = 0; k < count; ++k) {
    const float goal = float(k + 1) / float(count);
    float end = total;
    while (k + 1 < count && index < weights.size()) {
      const Interval& interval = index < head.size() ? head[index] : torso[index - head.size()];
      const float length = interval.far - interval.near;
      const float own = (1 - kEvenShare) * weights[index] + even * length;
      if (mass + own >= goal) {
        end = passed + length * std::clamp((goal - mass) / own, 0.f, 1.f);
        break;
      }
      mass += own, passed += length, ++index;
    }
    end = std::clamp(end, start, total);
    const float u = jitter == 0 ? 0.5f : unit_float(mix(jitter + std::uint64_t(k)));
    samples[k] = placing.at(start + u * (end - start));
    samples[k].dt = end - start;
    start = end;
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

MarchVolumes march_volumes(const FieldPart& head, const FieldPart* torso, std::span<const NeckBend> necks) {
  MarchVolumes volumes;
  volumes.fields[0] = march_volume(head.occupancy, head.core, head.cube.side, head.opacity);
  if (torso)
    volumes.fields[1] = march_volume(torso->occupancy, torso->core, torso->cube.side, torso->opacity);
  volumes.necks.resize(necks.size());
  parallel_ranges(necks.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) volumes.necks[i] = march_neck(necks[i], volumes.fields[0]);
  });
  return volumes;
}

namespace {

const MarchNeck* neck_of(const RayRequest& ray, const MarchVolumes& volumes, int field) {
  if (field != 0 || volumes.necks.empty()) return nullptr;
  return &volumes.necks[std::size_t(ray.view) % volumes.necks.size()];
}

struct RayIntervals {
  std::vector<Interval> head, torso;

  // Nothing beyond a core cell of one field is seen in the other either.
  void walk(const RayRequest& ray, const MarchVolumes& volumes) {
    head.clear(), torso.clear();
    float far = volumes.far;
    std::vector<Interval>* lists[2] = {&head, &torso};
    for (int f = 0; f < 2; ++f)
      if (volumes.fields[f].occupancy)
        far = std::min(far, occupied_intervals(ray.fields[f], volumes.fields[f], volumes.near, far, *lists[f],
                                               neck_of(ray, volumes, f)));
    if (far >= volumes.far) return;
    while (!head.empty() && head.back().near >= far) head.pop_back();
    if (head.empty() || head.back().far <= far) return;
    Interval& last = head.back();
    last.depth *= (far - last.near) / (last.far - last.near);
    last.far = far;
  }
};

}  // namespace

bool meets_volume(const RayRequest& ray, const MarchVolumes& volumes) {
  float far = volumes.far;
  for (int f = 0; f < 2; ++f) {
    if (!volumes.fields[f].occupancy) continue;
    bool met = false;
    far = std::min(far, walk_cells(ray.fields[f], volumes.fields[f], neck_of(ray, volumes, f), volumes.near,
                                   far, [&](float, float, std::uint8_t) {
                                     met = true;
                                     return false;
                                   }));
    if (met) return true;
  }
  return false;
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
