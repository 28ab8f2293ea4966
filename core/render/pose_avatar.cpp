// The rig of an avatar, and its poses: see pose_avatar.h.
#include "core/render/pose_avatar.h"

#include "core/base/check.h"

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

}  // namespace likeness
