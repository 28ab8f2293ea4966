// Posing an avatar: its head model turns an articulation into the state that the renderer uses.
#pragma once

#include <string>

#include "core/head/expression_detail.h"
#include "core/head/head_model.h"
#include "core/head/pose_head.h"
#include "core/render/avatar.h"
#include "core/render/render.h"
#include "core/scene/avatar_pose.h"
#include "core/scene/torso_warp.h"
#include "core/scene/warp_lattice.h"

namespace likeness {

// What all frames of one avatar share. Refers to the model, which must outlive it.
struct AvatarRig {
  const HeadModel* model = nullptr;
  HeadShape shape;
  WarpFrame warp;             // of the person's neutral face
  bool warps = false;         // the field was trained in the canonical face
  TorsoModes torso;           // empty: a rigid torso
  ExpressionDetail detail{};  // empty: none
};

// In words, where this person's face at rest is not of a head's size and place, as in a file that was
// altered; empty: it is. Its lists are as long as the model's.
std::string misplaced_rest(const HeadModel& model, const PersonShape& person, const Articulation& neutral,
                           const ExpressionDetail& detail = {});

// Whether an avatar's lists are as long as its head model needs them, and its face at rest of a head's size:
// a file may say anything.
Result<void> check_numbers_fit(const Avatar& avatar, const HeadModel& model);

// model: the one the avatar was made with; an Error, which says what does not fit, where the avatar's numbers
// cannot be its.
Result<AvatarRig> make_rig(const Avatar& avatar, const HeadModel& model);

// About 10 ms if the avatar warps.
RenderState pose_avatar(const AvatarRig& rig, const AvatarPose& pose);

}  // namespace likeness
