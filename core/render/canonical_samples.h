// Samples of posed fields moved to canonical space, where their fields are read.
#pragma once

#include <span>

#include "core/render/attribute.h"
#include "core/render/avatar.h"
#include "core/render/rays.h"
#include "core/scene/neck_bend.h"
#include "core/scene/torso_warp.h"
#include "core/scene/warp_lattice.h"

namespace likeness {

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
