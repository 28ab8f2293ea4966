// From a pixel to its field samples: rays in the fields' unit cubes, the walk through occupied cells, and the
// batches of samples shared between the head and the torso.
//
// A ray is x(t) = origin + t direction in the unit cube of a field, with t in metres along the unit world
// ray, so that one t means one point in both fields.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/linalg.h"
#include "core/camera/camera.h"
#include "core/render/avatar.h"
#include "core/render/strata.h"

namespace likeness {

struct FieldRay {
  Vec3f origin, direction;
};

// Camera coordinates (m) to the unit cube of a field: x = linear * p + offset.
struct UnitFromCamera {
  Eigen::Matrix3f linear;
  Vec3f offset;
  float side = 1;
};
UnitFromCamera unit_from_camera(const FieldCube& cube, const Pose& cam_from_world,
                                const Pose& world_from_field);

// direction_in_cam: unit length.
FieldRay field_ray(const UnitFromCamera& map, const Vec3f& direction_in_cam);

// Unit ray directions in the camera frame through the pixel centres, distortion undone. (height * width),
// row-major.
std::vector<Vec3f> pixel_directions(const Intrinsics& intrinsics);

// What rays need of a field's grids. bricks: one byte per block of 8^3 cells, (z, y, x), 0 where all are
// empty.
struct MarchVolume {
  const OccupancyGrid* occupancy = nullptr;  // null: the field is absent; empty: all occupied
  const OccupancyGrid* core = nullptr;       // null or empty: none
  float side = 1;                            // m
  std::span<const std::uint8_t> opacity;     // as in FieldPart
  std::vector<std::uint8_t> bricks;
  std::vector<Eigen::AlignedBox3f>
      layers;  // (blocks along y) around the blocks that are not empty, unit cube
};
MarchVolume march_volume(const OccupancyGrid& occupancy, const OccupancyGrid& core, float side = 1,
                         std::span<const std::uint8_t> opacity = {});

// A bent neck and the box that encloses, in this bend, everything the grids hold below the neck's top.
struct MarchNeck {
  const NeckBend* bend = nullptr;
  Eigen::AlignedBox3f box;  // unit cube
  // Contents of the cells in the box below the top, found once for all rays; empty: every ray looks them up
  // itself.
  std::array<int, 3> first{}, count{};  // cells
  std::vector<CellContent> cells;       // (z, y, x)
};
MarchNeck march_neck(const NeckBend& bend, const MarchVolume& head);
// Sets `first` and `count`.
void bound_neck(const MarchVolume& head, MarchNeck& neck);
// Also fills `cells`: worthwhile for a picture's rays, not for the few that training casts per view.
void look_up_neck(const MarchVolume& head, MarchNeck& neck);

// Optical depth of a cell's width by its opacity; for the most opaque it is a lower bound.
const std::array<float, 256>& depth_of_opacity();

// Appends the ray's stretches through occupied cells, in depth order, at most `far` away, and returns the
// distance at which it enters a core cell (nothing is seen beyond), or `far`. With known opacities every cell
// is a stretch of its own with its optical depth; otherwise stretches that touch are merged.
//
// neck: of the head's field, or null. A cell of a bent neck also counts as occupied if its place on the
// straight neck is; one whose place lies outside the cube is empty.
float occupied_intervals(const FieldRay& ray, const MarchVolume& volume, float near, float far,
                         std::vector<Interval>& intervals, const MarchNeck* neck = nullptr);

// Samples of many rays, grouped by field for evaluation and by ray for compositing.
struct FieldSamples {
  std::vector<float> x, y, z, dx, dy, dz;  // (N) unit cube; unit view direction in the field's frame
  std::vector<std::int32_t> view;          // (N) row of conditions and codes
  std::vector<float> local;                // (A, N) weights of the attributes; empty where there are none
  std::size_t count() const { return x.size(); }
  void resize(std::size_t count);
  FieldInputs inputs(const float* conditions, const float* latents) const;
};

struct SampleBatch {
  std::vector<std::uint32_t> begin;  // (R + 1) of ray r's samples in the three arrays below, in depth order
  std::vector<float> dt;             // in units of the sample's cube side: optical depth = sigma * dt
  std::vector<std::uint8_t> field;   // 0 head, 1 torso
  std::vector<std::uint32_t> slot;   // index into fields[field]
  std::array<FieldSamples, 2> fields;
  std::vector<RaySample> placed;  // (R, most a ray)
};

// One ray to be sampled. `fields[1]` is ignored if there is no torso.
struct RayRequest {
  std::array<FieldRay, 2> fields;
  std::int32_t view = 0;
  std::uint64_t jitter = 0;               // 0: midpoints
  std::array<float, 2> nothing_before{};  // m, of each field: where its walk may begin
};

struct WarpLattice;

// The head's cells in the canonical face: a place of the posed head is looked up only where the head model's
// deformation maps it (as Li 2022 does with a voxel grid of the canonical face). The head's own grid then
// only bounds the walk.
struct CanonicalCells {
  const OccupancyGrid* occupancy = nullptr;  // of the canonical face
  std::span<const std::uint8_t> opacity;     // as in FieldPart, of the canonical face
  const OccupancyGrid* kept = nullptr;       // of the posed head: cells that always count as occupied
  FieldCube cube;                            // of both
  const WarpLattice* lattices = nullptr;     // a ray's by its view modulo their number
  std::size_t count = 0;
};

struct MarchVolumes {
  std::array<MarchVolume, 2> fields;
  std::vector<MarchNeck> necks;               // of the head, a ray's by its view modulo their number; or none
  const CanonicalCells* canonical = nullptr;  // null: the head's grid is of the posed head
  int max_samples = 16;
  float min_step = 0.0015f;       // m
  float even_share = kEvenShare;  // of a ray's samples, as in place_samples
  float near = 0.05f, far = 20;   // m
};
// Refers to its arguments. necks: of the head's unit cube.
MarchVolumes march_volumes(const FieldPart& head, const FieldPart* torso,
                           std::span<const NeckBend> necks = {});

// In parallel; the result does not depend on the threads.
void sample_rays(std::span<const RayRequest> rays, const MarchVolumes& volumes, SampleBatch& batch);
// The strata of many rays.
struct RayStrata {
  std::vector<RayStratum> strata;   // of ray r, those of the numbers [begin[r], begin[r + 1]) of the batch
  std::vector<Interval> intervals;  // of the rays' walks
  std::vector<std::uint32_t>
      intervals_begin;  // (2 R + 1) of ray r: the head's at 2 r, the torso's at 2 r + 1
  std::span<const Interval> intervals_of(std::size_t ray, int field) const {
    const std::size_t i = 2 * ray + std::size_t(field);
    return std::span(intervals).subspan(intervals_begin[i], intervals_begin[i + 1] - intervals_begin[i]);
  }
};
// At most `most` a ray; fills `batch` with the samples in their midpoints. In one thread.
void stratify_rays(std::span<const RayRequest> rays, const MarchVolumes& volumes, int most,
                   SampleBatch& batch, RayStrata& out);
// Removes the samples of a ray that lie in no occupied cell; returns how many are left, their order kept.
int keep_occupied(const RayRequest& ray, const MarchVolumes& volumes, std::span<RaySample> samples);
// Samples at given places: of ray r, the first counts[r] of batch.placed[r * stride ...], in depth order.
void collect_samples(std::span<const RayRequest> rays, const MarchVolumes& volumes, std::size_t stride,
                     std::span<const int> counts, SampleBatch& batch);

// True where the ray meets an occupied cell of either field, hidden by the other's core or not. Notes in the
// ray what lies before it, so that sampling it does not walk there again.
bool meets_volume(RayRequest& ray, const MarchVolumes& volumes);

}  // namespace likeness
