// Rays, what cells hold, and the placing of samples.
#include "core/render/rays.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/render/march_math.h"
#include "core/scene/warp_lattice.h"

namespace likeness {
namespace {

UnitRay plain(const FieldRay& ray) {
  const auto &o = ray.origin, &d = ray.direction;
  return {{o.x(), o.y(), o.z()}, {d.x(), d.y(), d.z()}};
}

std::size_t index_of(int n, const int (&cell)[3]) {
  return (std::size_t(cell[2]) * n + cell[1]) * n + cell[0];
}

// The grid holds what the training poses showed in a cell; in another pose the neck there is looked up at its
// place on the straight neck.
CellContent content_of_neck(const NeckBend& neck, const MarchVolume& volume, const OccupancyGrid* core,
                            const int (&cell)[3]) {
  const int n = volume.occupancy->resolution;
  const Vec3f centre = Vec3f(float(cell[0]) + 0.5f, float(cell[1]) + 0.5f, float(cell[2]) + 0.5f) / float(n);
  const Vec3f place = straightened_in_lanes(neck, centre) * float(n);
  int at[3];
  for (int a = 0; a < 3; ++a) {
    if (!(place[a] >= 0 && place[a] < float(n))) return {};
    at[a] = int(place[a]);
  }
  return {volume.occupancy->occupied(cell[0], cell[1], cell[2]) ||
              volume.occupancy->occupied(at[0], at[1], at[2]),
          core && core->occupied(at[0], at[1], at[2]),
          volume.opacity.empty() ? std::uint8_t(0) : volume.opacity[index_of(n, at)]};
}

void mark_bricks(const OccupancyGrid& grid, std::vector<std::uint8_t>& bricks) {
  const int n = grid.resolution, m = bricks_along(n);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y) {
      std::uint8_t* const row = bricks.data() + (std::size_t(z / kBrick) * m + y / kBrick) * std::size_t(m);
      if (n % kBrick == 0) {
        const std::uint8_t* const bits = grid.bits.data() + (std::size_t(z) * n + y) * std::size_t(m);
        for (int b = 0; b < m; ++b) row[b] |= std::uint8_t(bits[b] != 0);
      } else {
        for (int x = 0; x < n; ++x) row[x / kBrick] |= std::uint8_t(grid.occupied(x, y, z));
      }
    }
}

// The canonical face's cells for the rays of one view.
struct CanonicalView {
  const CanonicalCells* cells = nullptr;  // null: the grid is of the posed head
  const WarpLattice* lattice = nullptr;   // null: nothing moves
};

CanonicalView canonical_view(const RayRequest& ray, const MarchVolumes& volumes, int field) {
  if (field != 0 || volumes.canonical == nullptr) return {};
  const CanonicalCells& cells = *volumes.canonical;
  return {&cells, cells.count == 0 ? nullptr : &cells.lattices[std::size_t(ray.view) % cells.count]};
}

// Contents of the cell of the canonical face to which the middle of a posed cell is mapped.
CellContent canonical_content(const CanonicalView& view, const MarchVolume& volume, const OccupancyGrid* core,
                              const NeckBend* bend, const int (&cell)[3]) {
  const CanonicalCells& cells = *view.cells;
  const int n = cells.occupancy->resolution;
  Vec3f at = Vec3f(float(cell[0]) + 0.5f, float(cell[1]) + 0.5f, float(cell[2]) + 0.5f) /
             float(volume.occupancy->resolution);
  if (view.lattice)
    at += displacement_at(*view.lattice, cells.cube.origin + cells.cube.side * at) / cells.cube.side;
  if (bend && at.y() < bend->top) at = straightened_in_lanes(*bend, at);
  int place[3];
  for (int a = 0; a < 3; ++a) place[a] = std::clamp(int(at[a] * float(n)), 0, n - 1);
  const bool kept = cells.kept && cells.kept->resolution == volume.occupancy->resolution &&
                    cells.kept->occupied(cell[0], cell[1], cell[2]);
  return {kept || cells.occupancy->occupied(place[0], place[1], place[2]),
          core && core->occupied(cell[0], cell[1], cell[2]),
          cells.opacity.empty() ? std::uint8_t(0) : cells.opacity[index_of(n, place)]};
}

// Contents of cells and bricks, with the neck bent.
struct CellContents {
  const MarchVolume& volume;
  const OccupancyGrid* core;        // or null
  const NeckBend* bend;             // null: nothing is bent
  const MarchNeck* neck = nullptr;  // of `bend`
  float top = 0;                    // of the neck, cells
  Eigen::AlignedBox3f box{};        // of what is bent, cells
  CanonicalView canonical;

  CellContents(const MarchVolume& v, const MarchNeck* neck, const CanonicalView& view)
      : volume(v), core(nullptr), bend(nullptr), canonical(view) {
    const int n = volume.occupancy->resolution;
    if (volume.core && volume.core->resolution == n) core = volume.core;
    if (!neck || neck->bend->straight) return;
    this->neck = neck;
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
    if (canonical.cells) {
      const Vec3f middle(float(cell[0]) + 0.5f, float(cell[1]) + 0.5f, float(cell[2]) + 0.5f);
      const bool of_neck = bend && middle.y() < top && box.contains(middle);
      return own || of_neck ? canonical_content(canonical, volume, core, bend, cell) : CellContent{};
    }
    if (bend && float(cell[1]) + 0.5f < top) {
      if (const CellContent* known = looked_up(cell)) return *known;
      const Vec3f centre(float(cell[0]) + 0.5f, float(cell[1]) + 0.5f, float(cell[2]) + 0.5f);
      return own || box.contains(centre) ? content_of_neck(*bend, volume, core, cell) : CellContent{};
    }
    return {own, core && core->occupied(cell[0], cell[1], cell[2]),
            volume.opacity.empty() ? std::uint8_t(0) : volume.opacity[index_of(occupancy.resolution, cell)]};
  }
  const CellContent* looked_up(const int (&cell)[3]) const {
    if (neck->cells.empty()) return nullptr;
    std::size_t i = 0;
    for (int a = 2; a >= 0; --a) {
      const int own = cell[a] - neck->first[std::size_t(a)];
      if (own < 0 || own >= neck->count[std::size_t(a)]) return nullptr;
      i = i * std::size_t(neck->count[std::size_t(a)]) + std::size_t(own);
    }
    return &neck->cells[i];
  }
};

template <class Visit>
float walk_volume(const FieldRay& ray, const MarchVolume& volume, const MarchNeck* neck,
                  const CanonicalView& view, float near, float far, const Visit& visit) {
  const CellContents contents(volume, neck, view);
  return walk_cells(plain(ray), volume.occupancy->resolution, contents, near, far, visit);
}

void append(std::vector<Interval>& intervals, std::size_t first, const Interval& next) {
  if (next.far <= next.near) return;
  if (intervals.size() > first && next.near - intervals.back().far < 1e-6f && next.depth == 0 &&
      intervals.back().depth == 0)
    intervals.back().far = next.far;
  else
    intervals.push_back(next);
}

}  // namespace

const std::array<float, 256>& depth_of_opacity() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> depths{};
    for (int i = 0; i < 256; ++i) depths[std::size_t(i)] = float(-std::log(1 - std::min(i, 254) / 255.0));
    return depths;
  }();
  return table;
}

UnitFromCamera unit_from_camera(const FieldCube& cube, const Pose& cam_from_world,
                                const Pose& world_from_field) {
  const Pose field_from_cam = inverse(cam_from_world * world_from_field);
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
    margin = 0.25f * layer.sizes().y();  // points within bend less evenly than the corners do
    for (int corner = 0; corner < 8; ++corner) {
      Vec3f at = layer.corner(Eigen::AlignedBox3f::CornerType(corner));
      at.y() = std::min(at.y(), bend.top);
      neck.box.extend(bent(bend, at));
    }
  }
  if (!neck.box.isEmpty()) neck.box.min().array() -= margin, neck.box.max().array() += margin;
  return neck;
}

void bound_neck(const MarchVolume& head, MarchNeck& neck) {
  if (neck.bend->straight || neck.box.isEmpty() || head.occupancy->resolution == 0) return;
  const int n = head.occupancy->resolution;
  std::array<int, 3> last{};  // one past
  for (int a = 0; a < 3; ++a) {
    const auto axis = std::size_t(a);
    // Cells whose centre lies in the box, and on y below the top, as CellContents::at decides.
    neck.first[axis] = std::clamp(int(std::ceil(neck.box.min()[a] * float(n) - 0.5f)), 0, n);
    last[axis] = std::clamp(int(std::floor(neck.box.max()[a] * float(n) - 0.5f)) + 1, neck.first[axis], n);
    if (a == 1) last[axis] = std::min(last[axis], int(std::ceil(neck.bend->top * float(n) - 0.5f)));
    neck.count[axis] = std::max(0, last[axis] - neck.first[axis]);
  }
}

void look_up_neck(const MarchVolume& head, MarchNeck& neck) {
  bound_neck(head, neck);
  const int n = head.occupancy->resolution;
  const OccupancyGrid* core = head.core && head.core->resolution == n ? head.core : nullptr;
  const auto [nx, ny, nz] = neck.count;
  neck.cells.resize(std::size_t(nx) * std::size_t(ny) * std::size_t(nz));
  parallel_ranges(std::size_t(nz), 4, [&, nx = nx, ny = ny](std::size_t begin, std::size_t end) {
    for (std::size_t z = begin; z < end; ++z)
      for (int y = 0; y < ny; ++y)
        for (int x = 0; x < nx; ++x) {
          const int cell[3] = {neck.first[0] + x, neck.first[1] + y, neck.first[2] + int(z)};
          neck.cells[(z * std::size_t(ny) + std::size_t(y)) * std::size_t(nx) + std::size_t(x)] =
              content_of_neck(*neck.bend, head, core, cell);
        }
  });
}

namespace {

float add_intervals(const FieldRay& ray, const MarchVolume& volume, float near, float far,
                    std::vector<Interval>& intervals, const MarchNeck* neck, const CanonicalView& view) {
  const std::size_t first = intervals.size();
  const float cells_per_m = float(volume.occupancy->resolution) * ray.direction.norm();
  return walk_volume(ray, volume, neck, view, near, far, [&](float t, float leave, std::uint8_t opacity) {
    const float depth = opacity == 0 ? 0 : depth_of_opacity()[opacity] * (leave - t) * cells_per_m;
    append(intervals, first, {t, leave, depth});
    return true;
  });
}

}  // namespace

float occupied_intervals(const FieldRay& ray, const MarchVolume& volume, float near, float far,
                         std::vector<Interval>& intervals, const MarchNeck* neck) {
  return add_intervals(ray, volume, near, far, intervals, neck, {});
}

MarchVolumes march_volumes(const FieldPart& head, const FieldPart* torso, std::span<const NeckBend> necks) {
  MarchVolumes volumes;
  volumes.fields[0] = march_volume(head.occupancy, head.core, head.cube.side, head.opacity);
  volumes.far = std::max(volumes.far, 4 * head.cube.side);  // a whole room, from beside it
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
        far = std::min(
            far, add_intervals(ray.fields[f], volumes.fields[f],
                               std::max(volumes.near, ray.nothing_before[std::size_t(f)]), far, *lists[f],
                               neck_of(ray, volumes, f), canonical_view(ray, volumes, f)));
    if (far >= volumes.far) return;
    while (!head.empty() && head.back().near >= far) head.pop_back();
    if (head.empty() || head.back().far <= far) return;
    Interval& last = head.back();
    last.depth *= (far - last.near) / (last.far - last.near);
    last.far = far;
  }
};

}  // namespace

bool meets_volume(RayRequest& ray, const MarchVolumes& volumes) {
  float before[2];
  const auto walk = [&](int f, float far, const auto& visit) {
    const MarchVolume& volume = volumes.fields[f];
    return volume.occupancy ? walk_volume(ray.fields[f], volume, neck_of(ray, volumes, f),
                                          canonical_view(ray, volumes, f), volumes.near, far, visit)
                            : far;
  };
  const bool met = meets_cells(walk, volumes.far, before);
  ray.nothing_before = {before[0], before[1]};
  return met;
}

void sample_rays(std::span<const RayRequest> rays, const MarchVolumes& volumes, SampleBatch& batch) {
  LIKENESS_CHECK(volumes.max_samples > 0, "max_samples %d", volumes.max_samples);
  const auto most = std::size_t(volumes.max_samples);
  batch.placed.resize(rays.size() * most);
  std::vector<int> counts(rays.size());
  parallel_ranges(rays.size(), 256, [&](std::size_t first, std::size_t last) {
    RayIntervals intervals;
    for (std::size_t r = first; r < last; ++r) {
      intervals.walk(rays[r], volumes);
      counts[r] = place_samples(intervals.head, intervals.torso, volumes.min_step, volumes.even_share,
                                rays[r].jitter, {batch.placed.data() + r * most, most});
    }
  });
  collect_samples(rays, volumes, most, counts, batch);
}

void stratify_rays(std::span<const RayRequest> rays, const MarchVolumes& volumes, int max_strata,
                   SampleBatch& batch, RayStrata& out) {
  LIKENESS_CHECK(max_strata > 0, "at most %d strata", max_strata);
  const auto most = std::size_t(max_strata);
  out.strata.clear(), out.intervals.clear(), out.intervals_begin.assign(1, 0);
  batch.placed.resize(rays.size() * most);
  std::vector<int> counts(rays.size());
  std::vector<RayStratum> mine(most);
  RayIntervals intervals;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    intervals.walk(rays[r], volumes);
    counts[r] = place_strata(intervals.head, intervals.torso, volumes.min_step, mine);
    out.strata.insert(out.strata.end(), mine.begin(), mine.begin() + counts[r]);
    for (std::size_t k = 0; k < std::size_t(counts[r]); ++k) batch.placed[r * most + k] = mine[k].sample;
    for (const std::vector<Interval>* list : {&intervals.head, &intervals.torso}) {
      out.intervals.insert(out.intervals.end(), list->begin(), list->end());
      out.intervals_begin.push_back(std::uint32_t(out.intervals.size()));
    }
  }
  collect_samples(rays, volumes, most, counts, batch);
}

int keep_occupied(const RayRequest& ray, const MarchVolumes& volumes, std::span<RaySample> samples) {
  std::size_t kept = 0;
  for (int f = 0; f < 2; ++f) {
    const MarchVolume& volume = volumes.fields[f];
    if (!volume.occupancy) continue;
    const CellContents contents(volume, neck_of(ray, volumes, f), canonical_view(ray, volumes, f));
    const auto n = float(volume.occupancy->resolution);
    for (RaySample& s : samples) {
      if (s.field != f) continue;
      const Vec3f p = ray.fields[f].origin + s.t * ray.fields[f].direction;
      const bool inside = (p.array() >= 0).all() && (p.array() < 1).all();
      if (!inside) {
        s.dt = 0;
        continue;
      }
      const Vec3f at = n * p;
      const int cell[3] = {int(at.x()), int(at.y()), int(at.z())};
      if (n > 0 && !contents.at(cell).occupied) s.dt = 0;
    }
  }
  for (const RaySample& s : samples)
    if (s.dt > 0) samples[kept++] = s;
  return int(kept);
}

void collect_samples(std::span<const RayRequest> rays, const MarchVolumes& volumes, std::size_t stride,
                     std::span<const int> counts, SampleBatch& batch) {
  LIKENESS_CHECK(counts.size() == rays.size() && batch.placed.size() >= rays.size() * stride,
                 "%zu counts and %zu places for %zu rays", counts.size(), batch.placed.size(), rays.size());
  const std::vector<RaySample>& samples = batch.placed;
  // -- Offsets, then each ray fills its own places.
  batch.begin.resize(rays.size() + 1);
  std::vector<std::array<std::uint32_t, 2>> offsets(rays.size() + 1);
  offsets[0] = {0, 0};
  for (std::size_t r = 0; r < rays.size(); ++r) {
    batch.begin[r] = offsets[r][0] + offsets[r][1];
    offsets[r + 1] = offsets[r];
    for (std::size_t k = r * stride; k < r * stride + std::size_t(counts[r]); ++k)
      ++offsets[r + 1][std::size_t(samples[k].field)];
  }
  const std::size_t total = std::size_t(offsets.back()[0]) + offsets.back()[1];
  batch.begin[rays.size()] = std::uint32_t(total);
  batch.dt.resize(total), batch.field.resize(total), batch.slot.resize(total);
  for (int f = 0; f < 2; ++f) batch.fields[f].resize(offsets.back()[f]);

  parallel_ranges(rays.size(), 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t r = first; r < last; ++r) {
      std::array<std::uint32_t, 2> slot = offsets[r];
      for (std::size_t i = batch.begin[r], k = r * stride; i < batch.begin[r + 1]; ++i, ++k) {
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
