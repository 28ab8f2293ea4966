// The rig of an avatar, and its poses: see pose_avatar.h.
#include "core/render/pose_avatar.h"

#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace likeness {

namespace {

// m that a person's resting vertex may lie from the head model's own: heads differ by centimetres.
constexpr float kFarthestVertex = 1;

Error does_not_fit(std::string what) {
  return {ErrorCode::bad_input, "The avatar does not fit its head model: " + std::move(what) + ".",
          "Restore avatar.bin from a backup, or train the avatar again: likeness build", "avatar.bin"};
}

// What of the avatar's lists is not as long as the model needs it; empty: all is.
std::string wrong_count(const Avatar& avatar, const HeadModel& model) {
  const auto expressions = model.expression_count();
  if (avatar.person.identity.size() > model.identity_count())
    return fmt::format("it has {} numbers of identity, the model {}", avatar.person.identity.size(),
                       model.identity_count());
  if (!avatar.person.offsets.empty() && int(avatar.person.offsets.size()) != model.vertex_count())
    return fmt::format("its personal shape has {} vertices, the model {}", avatar.person.offsets.size(),
                       model.vertex_count());
  if (avatar.neutral.expression.size() != expressions)
    return fmt::format("its face at rest has {} expressions, the model {}", avatar.neutral.expression.size(),
                       expressions);
  if (avatar.condition.rows.rows() > 0 && avatar.condition.mean.size() != expressions + 9)
    return fmt::format("its field heard {} expressions, the model has {}", avatar.condition.mean.size() - 9,
                       expressions);
  if (!avatar.detail.empty() && !is_consistent(avatar.detail, model.vertex_count(), expressions))
    return "its detail is that of another head";
  return {};
}

}  // namespace

std::string misplaced_rest(const HeadModel& model, const PersonShape& person, const Articulation& neutral,
                           const ExpressionDetail& detail) {
  const std::vector<Vec3f> posed = pose_detailed_head(model, shape_head(model, person), neutral, detail);
  for (std::size_t v = 0; v < posed.size(); ++v)
    if (const float far = (posed[v] - model.vertices[v]).norm(); !(far <= kFarthestVertex))
      return fmt::format("vertex {} of its face at rest lies {:.3g} m from the model's", v, far);
  return {};
}

Result<void> check_numbers_fit(const Avatar& avatar, const HeadModel& model) {
  std::string wrong = wrong_count(avatar, model);
  if (wrong.empty()) wrong = misplaced_rest(model, avatar.person, avatar.neutral, avatar.detail);
  if (!wrong.empty()) return does_not_fit(std::move(wrong));
  return {};
}

Result<AvatarRig> make_rig(const Avatar& avatar, const HeadModel& model) {
  if (auto fits = check_numbers_fit(avatar, model); !fits) return fits.error();
  AvatarRig rig{&model,       shape_head(model, avatar.person), {}, avatar.warp_cell > 0, avatar.torso_modes,
                avatar.detail};
  if (!rig.warps) return rig;
  auto warp = make_warp_frame(model, rig.shape, avatar.neutral, avatar.warp_cell, &avatar.detail);
  if (!warp) return warp.error();
  rig.warp = std::move(*warp);
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
