// See sides_seen.h.
#include "core/train/sides_seen.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/train/head_marks.h"
#include "core/train/ray_choice.h"

namespace likeness {
namespace {

constexpr int kCells = 32;          // along an axis; multiples of 8 only
constexpr float kTurnedTo = 0.42f;  // cosine

}  // namespace

OccupancyGrid sides_seen(const TrainingSet& set, const HeadShape& shape, const FieldCube& head) {
  const Vec3f middle = head_middle(set.model, shape.vertices);
  std::vector<Vec3f> eyes;
  for (const TrainingView& view : own_views(set)) {
    const Pose head_from_cam = inverse(view.camera.cam_from_world * view.pose.world_from_head);
    eyes.push_back((head_from_cam.translation().cast<float>() - middle).normalized());
  }
  OccupancyGrid seen = make_occupancy(kCells, false);
  for (int z = 0; z < kCells; ++z)
    for (int y = 0; y < kCells; ++y)
      for (int x = 0; x < kCells; ++x) {
        const Vec3f cell(float(x) + 0.5f, float(y) + 0.5f, float(z) + 0.5f);
        const Vec3f out = (head.origin + cell * (head.side / kCells) - middle).normalized();
        if (std::ranges::any_of(eyes, [&](const Vec3f& eye) { return eye.dot(out) > kTurnedTo; }))
          set_occupied(seen, x, y, z, true);
      }
  return seen;
}

void drop_codes_on_new_sides(const OccupancyGrid& seen, std::size_t views, std::size_t own,
                             std::uint64_t seed, std::uint64_t step, FieldSamples& samples) {
  const int n = seen.resolution;
  if (n == 0 || own == views) return;
  parallel_ranges(samples.count(), kSampleStream, [&](std::size_t begin, std::size_t end) {
    RandomStream random = stream_of_sample(seed ^ kSideStream, step, begin);
    for (std::size_t i = begin; i < end; ++i) {
      const bool shown = holds(seen, cell_of_place(n, samples.x[i], samples.y[i], samples.z[i]));
      samples.view[i] = row_on_side(samples.view[i], std::uint32_t(views), std::uint32_t(own), shown, random);
    }
  });
}

}  // namespace likeness
