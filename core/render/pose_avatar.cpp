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
  AvatarRig rig{&model, shape_head(model, avatar.person), {}, avatar.warp_cell > 0};
  if (rig.warps) rig.warp = make_warp_frame(model, rig.shape, avatar.neutral, avatar.warp_cell);
  return rig;
}

RenderState pose_avatar(const AvatarRig& rig, const Pose& world_from_head, const Pose& world_from_torso,
                        const Articulation& articulation) {
  RenderState state{world_from_head, world_from_torso, articulation, {}};
  if (rig.warps) state.warp = make_warp_lattice(rig.warp, pose_head(*rig.model, rig.shape, articulation));
  return state;
}

void warp_samples(std::span<const WarpLattice> lattices, const FieldCube& cube, FieldSamples& samples) {
  if (lattices.empty()) return;
  parallel_ranges(samples.count(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const WarpLattice& lattice = lattices[std::size_t(samples.view[i]) % lattices.size()];
      const Vec3f unit(samples.x[i], samples.y[i], samples.z[i]);
      const Vec3f way = displacement_at(lattice, cube.origin + cube.side * unit) / cube.side;
      const Vec3f canonical = (unit + way).cwiseMax(0.f).cwiseMin(1.f);
      samples.x[i] = canonical.x(), samples.y[i] = canonical.y(), samples.z[i] = canonical.z();
    }
  });
}

}  // namespace likeness
