// From a pixel to its field samples: rays in the fields' unit cubes, the walk through occupied cells, and at
// most 16 samples a ray shared between the head and the torso.
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

struct Interval {
  float near = 0, far = 0;  // m along the ray
  float depth = 0;          // optical depth expected in it; 0: not known
};

// What rays need of a field's grids. bricks: one byte a block of 8^3 cells, (z, y, x), 0 where all are empty.
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

// A bent neck and the box that holds, in this bend, whatever the grids hold below the neck's top.
struct MarchNeck {
  const NeckBend* bend = nullptr;
  Eigen::AlignedBox3f box;  // unit cube
};
MarchNeck march_neck(const NeckBend& bend, const MarchVolume& head);

// Appends the ray's stretches through occupied cells, in depth order, at most `far` away, and returns the
// distance at which it enters a core cell (nothing is seen beyond), or `far`. With known opacities every cell
// is a stretch of its own with its optical depth; otherwise stretches that touch are merged.
//
// neck: of the head's field, or null. A cell of a bent neck also counts as occupied where its place on the
// straight neck is; one whose place lies outside the cube is empty.
float occupied_intervals(const FieldRay& ray, const MarchVolume& volume, float near, float far,
                         std::vector<Interval>& intervals, const MarchNeck* neck = nullptr);

struct RaySample {
  float t = 0;    // m
  float dt = 0;   // m of ray this sample stands for
  int field = 0;  // 0 head, 1 torso
};

// Cuts the length of both lists (head first) into strata, at most `samples.size()` of them and on average no
// shorter than min_step, puts a sample into each and sorts them by depth; returns how many. Strata are short
// where the light is expected to be lost (transmittance times opacity, by the intervals' optical depths), but
// kEvenShare of them is spread over the whole length, and so is the share of the light that is expected to
// pass. jitter 0: midpoints; otherwise a seed that places each sample anywhere in its stratum.
inline constexpr float kEvenShare = 0.25f;
int place_samples(std::span<const Interval> head, std::span<const Interval> torso, float min_step,
                  std::uint64_t jitter, std::span<RaySample> samples);

// Samples of many rays, grouped by field for evaluation and by ray for compositing.
struct FieldSamples {
  std::vector<float> x, y, z, dx, dy, dz;  // (N) unit cube; unit view direction in the field's frame
  std::vector<std::int32_t> view;          // (N) row of conditions and codes
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
  std::vector<RaySample> placed;  // scratch, kept between batches
};

// One ray to be sampled. `fields[1]` is ignored where there is no torso.
struct RayRequest {
  std::array<FieldRay, 2> fields;
  std::int32_t view = 0;
  std::uint64_t jitter = 0;  // 0: midpoints
};

struct MarchVolumes {
  std::array<MarchVolume, 2> fields;
  std::vector<MarchNeck> necks;  // of the head, a ray's by its view modulo their number; or none
  int max_samples = 16;
  float min_step = 0.0015f;      // m
  float near = 0.05f, far = 20;  // m
};
// Refers to its arguments. necks: of the head's unit cube.
MarchVolumes march_volumes(const FieldPart& head, const FieldPart* torso,
                           std::span<const NeckBend> necks = {});

// In parallel; the result does not depend on the threads.
void sample_rays(std::span<const RayRequest> rays, const MarchVolumes& volumes, SampleBatch& batch);

// True where the ray meets an occupied cell of either field, hidden by the other's core or not.
bool meets_volume(const RayRequest& ray, const MarchVolumes& volumes);

}  // namespace likeness
