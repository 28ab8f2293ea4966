// The pixels that are rendered together. Internal to core/render.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/linalg.h"
#include "core/camera/camera.h"
#include "core/image/image.h"

namespace likeness {

// Pixels that are rendered together, and the blocks of them that share their strata.
struct Band {
  std::vector<std::uint32_t> place;     // (pixels) where each result goes
  std::vector<Vec3f> directions;        // (pixels) in the camera frame
  std::vector<Vec3f> blocks;            // (blocks) directions of their middles
  std::vector<std::uint32_t> block_of;  // (pixels)
  bool empty_blocks_walk = false;       // pixels may meet the volume where their block's ray does not
  int block_columns = 0;  // of blocks that lie side by side, row by row; 0: they are not neighbours
};

// A square tile of the picture, its blocks of block x block pixels. Its samples' memory fits into the
// second-level cache.
inline constexpr int kTileSide = 32;  // pixels
Band tile_band(const Intrinsics& k, int left, int top, int block);

// Pixels [first, last) of a list of row-major indices, each its own block.
Band listed_band(const Intrinsics& k, std::span<const std::uint32_t> pixels, std::size_t first,
                 std::size_t last);

// -- A picture rendered at a fraction of its size and enlarged

// Intrinsics of a picture whose size is divided by `reduce`.
Intrinsics reduced(const Intrinsics& full, int reduce);

// The factor by which a picture with this many rays (at least one) is reduced: 1 if they suffice for each
// pixel, otherwise such that a quarter of them or more is left over.
int reduction(const Intrinsics& full, std::size_t rays);

// The pixels of the whole picture lie in cells between the centres of four pixels of the reduced one,
// `picture`, from (x, y) to (x + 1, y + 1); cells at the border, from (-1, -1) on, have fewer corners.
// Returned are those with a side along which the picture differs by more than `contrast` in a channel, row by
// row; if there are more than `most`, those that differ the most.
std::vector<Eigen::Vector2i> edge_cells(const Image& picture, float contrast, std::size_t most);

// The pixels of the whole picture (k) in such cells of the reduced one (fewer). The cells are their blocks.
Band edge_band(const Intrinsics& k, const Intrinsics& fewer, std::span<const Eigen::Vector2i> cells);

}  // namespace likeness
