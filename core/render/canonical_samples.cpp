// See canonical_samples.h.
#include "core/render/canonical_samples.h"

#include <algorithm>
#include <cstddef>

#include "core/base/parallel.h"

namespace likeness {

void warp_samples(std::span<const WarpLattice> lattices, const FieldCube& cube, FieldSamples& samples) {
  if (lattices.empty()) return;
  parallel_ranges(samples.count(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin, next = begin; i < end; i = next) {  // runs of one view
      while (next < end && samples.view[next] == samples.view[i]) ++next;
      displace_points(lattices[std::size_t(samples.view[i]) % lattices.size()], cube.origin, cube.side,
                      next - i, samples.x.data() + i, samples.y.data() + i, samples.z.data() + i);
    }
  });
}

void straighten_samples(std::span<const NeckBend> necks, FieldSamples& samples) {
  if (necks.empty()) return;
  parallel_ranges(samples.count(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const NeckBend& neck = necks[std::size_t(samples.view[i]) % necks.size()];
      if (neck.straight || samples.y[i] >= neck.top) continue;
      const Vec3f straight = straightened_in_lanes(neck, {samples.x[i], samples.y[i], samples.z[i]});
      samples.x[i] = std::clamp(straight.x(), 0.f, 1.f);
      samples.y[i] = std::clamp(straight.y(), 0.f, 1.f);
      samples.z[i] = std::clamp(straight.z(), 0.f, 1.f);
    }
  });
}

void weigh_attributes(std::span<const AttributeRegion> regions, const FieldCube& cube,
                      FieldSamples& samples) {
  const std::size_t count = samples.count();
  samples.local.resize(regions.size() * count);
  if (regions.empty()) return;
  parallel_ranges(count, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3f at = cube.origin + cube.side * Vec3f(samples.x[i], samples.y[i], samples.z[i]);
      for (std::size_t a = 0; a < regions.size(); ++a)
        samples.local[a * count + i] = region_weight(regions[a], at);
    }
  });
}

void warp_samples(std::span<const TorsoField> fields, const FieldCube& cube, FieldSamples& samples) {
  if (fields.empty()) return;
  parallel_ranges(samples.count(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const TorsoField& field = fields[std::size_t(samples.view[i]) % fields.size()];
      const Vec3f unit(samples.x[i], samples.y[i], samples.z[i]);
      const Vec3f way = torso_displacement(field, cube.origin + cube.side * unit) / cube.side;
      const Vec3f canonical = (unit + way).cwiseMax(0.f).cwiseMin(1.f);
      samples.x[i] = canonical.x(), samples.y[i] = canonical.y(), samples.z[i] = canonical.z();
    }
  });
}

}  // namespace likeness
