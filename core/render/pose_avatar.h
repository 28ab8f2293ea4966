// Posing an avatar: its head model turns an articulation into the state that the renderer uses.
#pragma once

#include <span>

#include "core/head/pose_head.h"
#include "core/render/rays.h"
#include "core/render/render.h"
#include "core/scene/avatar_pose.h"
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

// model: the one the avatar was made with.
AvatarRig make_rig(const Avatar& avatar, const HeadModel& model);

// About 10 ms if the avatar warps.
RenderState pose_avatar(const AvatarRig& rig, const AvatarPose& pose);

// Moves samples of the head field to canonical, by the lattice of their view (row modulo the number of
// lattices). No lattices: nothing to do. In parallel.
void warp_samples(std::span<const WarpLattice> lattices, const FieldCube& cube, FieldSamples& samples);
// Moves samples of the head field near a bent neck to the straight one, by the bend of their view in the
// field's unit cube. After the lattices: a chin lowered by the jaw is not neck.
void straighten_samples(std::span<const NeckBend> necks, FieldSamples& samples);
// Weights of the attributes at the samples, which are in canonical space. No regions: none.
void weigh_attributes(std::span<const AttributeRegion> regions, const FieldCube& cube, FieldSamples& samples);
// Moves torso samples to canonical.
void warp_samples(std::span<const TorsoField> fields, const FieldCube& cube, FieldSamples& samples);

}  // namespace likeness
