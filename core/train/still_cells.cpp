#include "core/train/still_cells.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/train/ray_choice.h"

namespace likeness {
namespace {

constexpr std::size_t kMaxPosed = 64;  // articulations looked at, spread evenly

// Largest displacement of each vertex from its mean place over the articulations, m.
std::vector<float> largest_motion(const HeadModel& model, const HeadShape& shape,
                                  std::span<const Articulation> articulations) {
  const std::size_t count = std::min(articulations.size(), kMaxPosed);
  std::vector<std::vector<Vec3f>> posed(count);
  parallel_for(count, [&](std::size_t i) {
    posed[i] = pose_head(model, shape, articulations[i * articulations.size() / count]);
  });
  std::vector<float> motion(model.vertices.size(), 0.f);
  for (std::size_t v = 0; v < motion.size(); ++v) {
    Vec3f mean = Vec3f::Zero();
    for (const auto& vertices : posed) mean += vertices[v] / float(count);
    for (const auto& vertices : posed) motion[v] = std::max(motion[v], (vertices[v] - mean).norm());
  }
  return motion;
}

}  // namespace

OccupancyGrid still_cells(const HeadModel& model, const HeadShape& shape,
                          std::span<const Articulation> articulations, const FieldCube& cube, int resolution,
                          const StillOptions& options) {
  OccupancyGrid still = make_occupancy(resolution, true);
  const std::vector<float> motion = largest_motion(model, shape, articulations);
  const std::vector<Vec3f> rest = pose_head(model, shape, neutral_articulation(model));
  const float cell = cube.side / float(resolution), reach = options.reach / cell;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    if (motion[v] < options.moved) continue;
    const Vec3f at = (rest[v] - cube.origin) / cell;
    const auto from = [&](int axis) { return std::max(0, int(std::floor(at[axis] - reach))); };
    const auto to = [&](int axis) { return std::min(resolution - 1, int(std::floor(at[axis] + reach))); };
    for (int z = from(2); z <= to(2); ++z)
      for (int y = from(1); y <= to(1); ++y)
        for (int x = from(0); x <= to(0); ++x)
          if ((Vec3f(float(x) + 0.5f, float(y) + 0.5f, float(z) + 0.5f) - at).norm() <= reach)
            set_occupied(still, x, y, z, false);
  }
  return still;
}

void clear_region(const AttributeRegion& region, const FieldCube& cube, OccupancyGrid& still) {
  const int n = still.resolution;
  if (n == 0) return;
  // Corners too: the weight may be 0 in a cell's middle and not at its edge.
  const float cell = cube.side / float(n);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (int corner = 0; corner < 9; ++corner) {
          const Vec3f part = corner == 8
                                 ? Vec3f(0.5f, 0.5f, 0.5f)
                                 : Vec3f(float(corner & 1), float(corner >> 1 & 1), float(corner >> 2));
          const Vec3f at = cube.origin + cell * (Vec3f(float(x), float(y), float(z)) + part);
          if (region_weight(region, at) > 0) set_occupied(still, x, y, z, false);
        }
}

void shuffle_conditions(const OccupancyGrid& still, std::size_t views, std::size_t own, std::uint64_t seed,
                        std::uint64_t step, FieldSamples& samples) {
  const int n = still.resolution;
  if (n == 0 || views == 0) return;
  parallel_ranges(samples.count(), kSampleStream, [&](std::size_t begin, std::size_t end) {
    RandomStream random = stream_of_sample(seed ^ kStillStream, step, begin);
    for (std::size_t i = begin; i < end; ++i) {
      const bool quiet = holds(still, cell_of_place(n, samples.x[i], samples.y[i], samples.z[i]));
      samples.view[i] =
          shuffled_row(samples.view[i], std::uint32_t(views), std::uint32_t(own), quiet, random);
    }
  });
}

}  // namespace likeness
