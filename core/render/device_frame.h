// What is copied to a device for a picture: the order of its pixels, once per size, and the pose, once per
// frame; for training (core/train/cast_rays.h) the poses of its views.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/camera/camera.h"
#include "core/device/device.h"
#include "core/render/backend.h"
#include "core/render/device_march.h"
#include "core/render/rays.h"
#include "core/render/render.h"

namespace likeness {

// Pixels and blocks that are rendered together: whole tiles (pixel_bands.h).
struct PictureBand {
  std::size_t first_pixel = 0, pixels = 0, first_block = 0, blocks = 0;
};

// The pixels of a picture, tile by tile.
struct PictureTiles {
  std::vector<float> directions;        // (pixels, 3) camera frame
  std::vector<std::uint32_t> place;     // (pixels) in the picture
  std::vector<std::uint32_t> block;     // (pixels) within the band
  std::vector<float> block_directions;  // (blocks, 3)
  std::vector<BlockPlace> block_place;  // (blocks) within the band
  std::vector<PictureBand> bands;
};
std::size_t tile_count(const Intrinsics& k);
PictureTiles picture_tiles(const Intrinsics& k, int block, std::size_t tiles_per_band);

// Whether a recording made for one picture is valid for another.
bool same_picture(const Intrinsics& a, const Intrinsics& b);
bool same_options(const RenderOptions& a, const RenderOptions& b);

// A pose in the device's form. Null: there is none, or nothing moves.
struct FrameParts {
  std::array<const UnitFromCamera*, 2> maps{};  // head, torso
  const NeckBend* neck = nullptr;               // of the head's unit cube
  const WarpLattice* warp = nullptr;
  const TorsoField* torso = nullptr;
};
// The bytes of FrameNumbers and the tables behind it, in place of what `out` holds. head: for the neck's box;
// null: the box is computed elsewhere.
void pack_frame(const FrameParts& parts, const MarchVolume* head, std::vector<unsigned char>& out);
// The same for an avatar.
void pack_frame(const Avatar& avatar, const Camera& camera, const RenderState& state, const MarchVolume& head,
                std::vector<unsigned char>& out);

// The avatar must stay as and where it is. halves: as device_backend.
Result<std::unique_ptr<FrameRenderer>> device_renderer(std::shared_ptr<Device> device, const Avatar& avatar,
                                                       bool halves);

}  // namespace likeness
