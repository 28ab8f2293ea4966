// Posing an avatar: its head model turns an articulation into the state that the renderer draws.
#pragma once

#include <span>

#include "core/head/pose_head.h"
#include "core/render/rays.h"
#include "core/render/render.h"
#include "core/scene/warp_lattice.h"

namespace likeness {

// What all frames of one avatar share. Refers to the model, which must outlive it.
struct AvatarRig {
  const HeadModel* model = nullptr;
  HeadShape shape;
  WarpFrame warp;      // of the person's neutral face
  bool warps = false;  // the field was trained in the canonical face
};

// model: the one the avatar was made with.
AvatarRig make_rig(const Avatar& avatar, const HeadModel& model);

// Poses in m. About 10 ms where the avatar warps.
RenderState pose_avatar(const AvatarRig& rig, const Pose& world_from_head, const Pose& world_from_torso,
                        const Articulation& articulation);

// Moves samples of the head field to canonical, by the lattice of their view (row modulo the number of
// lattices). No lattices: nothing to do. In parallel.
void warp_samples(std::span<const WarpLattice> lattices, const FieldCube& cube, FieldSamples& samples);

}  // namespace likeness
