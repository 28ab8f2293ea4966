// The rig of an avatar, and samples moved to canonical.
#include "core/render/pose_avatar.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace likeness {
AvatarRig make_rig(const Avatar& avatar, const HeadModel& model) {
  LIKENESS_CHECK(avatar.person.offsets.empty() || int(avatar.person.offsets.size()) == model.vertex_count(),
                 "a person of %d vertices, a head model of %d", int(avatar.person.offsets.size()),
                 model.vertex_count());
  LIKENESS_CHECK(
      avatar.detail.empty() || is_consistent(avatar.detail, model.vertex_count(), model.expression_count()),
      "a detail of %d vertices for a head model of %d", int(avatar.detail.vertices.size()),
      model.vertex_count());
  AvatarRig rig{&model,       shape_head(model, avatar.person), {}, avatar.warp_cell > 0, avatar.torso_modes,
                avatar.detail};
  if (rig.warps)
    rig.warp = make_warp_frame(model, rig.shape, avatar.neutral, avatar.warp_cell, &avatar.detail);
  return rig;
}

RenderState pose_avatar(const AvatarRig& rig, const AvatarPose& pose) {
  RenderState state{.pose = pose, .torso = torso_field(rig.torso, pose.torso_shape)};
  if (rig.warps)
    state.warp = make_warp_lattice(
        rig.warp, pose_detailed_head(*rig.model, rig.shape, pose.articulation, rig.detail, pose.detail));
  return state;
}

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
