// The rays of one training step: which views and pixels, what colour they should have, and over which
// background.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/head/pose_head.h"
#include "core/render/patch_loss.h"
#include "core/render/pose_avatar.h"
#include "core/render/rays.h"
#include "core/scene/warp_lattice.h"
#include "core/train/landmark_patches.h"
#include "core/train/mosaic_place.h"
#include "core/train/train.h"

namespace likeness {

struct RayBatch {
  std::vector<RayRequest> requests;       // (R) view = row of conditions: v with its code, v + views without
  std::vector<Vec3f> target, background;  // (R) sRGB-encoded
  std::vector<RayPatch> patches;          // of the first rays; their maps are the source's
};

// What the choice of rays needs of the views, prepared once.
struct RaySource {
  const TrainingSet* set = nullptr;
  struct View {
    std::array<UnitFromCamera, 2> maps;
    Vec3f gain = Vec3f::Ones();  // of a further clip's colours: its faces are as bright as the first clip's
    MosaicPlace mosaic{};        // width 0: the view's plate is no mosaic, or it has none
    int face_x0 = 0, face_y0 = 0, face_x1 = 0, face_y1 = 0;  // px, half open; empty: whole picture
  };
  std::vector<View> views;                   // of the set's views, then of its proxies
  std::size_t drawn = SIZE_MAX;              // rays are drawn from this many first views
  std::uint64_t proxies_until = UINT64_MAX;  // the first step of the proxies' late share (ray_choice.h)
  std::vector<WarpLattice> warps;            // one per view, or none: the head field is not warped
  std::vector<TorsoField> torsos;            // one per view, or none: a rigid torso
  std::vector<NeckBend> necks;               // one per view, or none: no neck to bend
  OccupancyGrid sides;  // sides of the head that the first clip shows; empty without further clips
  const LandmarkPatches* patches = nullptr;  // null: no rays in patches
};
// Where a view sees its mosaic; of width 0 where it has none.
MosaicPlace mosaic_place(const TrainingSet& set, const TrainingView& view);

// poses: of the views, as tracked or corrected, and of the proxies. warp: of the canonical face; null: none.
// neck: empty: none.
RaySource make_ray_source(const TrainingSet& set, std::span<const AvatarPose> poses, const HeadShape& shape,
                          const FieldCube& head, const FieldCube* torso, const WarpFrame* warp = nullptr,
                          const NeckZone& neck = {});

// Proxies in their share, without a code, the views in turn; a quarter of the rays in the face's box, half on
// the person, the rest anywhere, all but a few where an occupied cell can be seen; at most a third from
// further clips, only the head's and the background's, each with its view's code. A third of the rays with a
// matte get a random background, so that the person does not borrow the plate's colour. Every number depends
// only on seed, step and the ray's index.
//
// With patches the first quarter of the rays are whole ones, each around a landmark of a view (of the first
// clip): all its rays with the view's code or all without, before the plate.
void choose_rays(const RaySource& source, const MarchVolumes& volumes, bool drop_codes, std::uint64_t seed,
                 std::uint64_t step, int count, RayBatch& batch);

}  // namespace likeness
