// Values stored at the nodes of a regular grid over a field's unit cube, only where there is something:
// blocks of 8^3 cells with all their 9^3 nodes, so that a look-up stays within its block (Hedman et al. 2021,
// SNeRG, section 4.3, where a block has the same rim).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/render/avatar.h"
#include "core/render/rays.h"

namespace likeness {

inline constexpr int kVoxelBlock = 8;                // cells of a block, along an axis
inline constexpr int kVoxelNodes = kVoxelBlock + 1;  // nodes of one
inline constexpr std::size_t kNodesOfBlock = std::size_t(kVoxelNodes) * kVoxelNodes * kVoxelNodes;

struct SparseVoxels {
  int resolution = 0;  // cells along an axis, a multiple of kVoxelBlock
  int channels = 0;    // values of a node; the first is the density per cube side
  std::vector<std::int32_t>
      blocks;                // (n, n, n) by (z, y, x), n = resolution / kVoxelBlock; -1: nothing there
  std::vector<float> nodes;  // (stored blocks, z, y, x, channels)

  std::size_t stored_blocks() const { return nodes.size() / (kNodesOfBlock * std::size_t(channels)); }
  std::size_t bytes() const { return nodes.size() * sizeof(float) + blocks.size() * sizeof(std::int32_t); }
};

// A place between its eight nodes.
struct VoxelPlace {
  const float* node = nullptr;  // the one of the lowest coordinates; null: nothing is stored there
  float x = 0, y = 0, z = 0;    // in [0, 1], between it and the highest ones
};
VoxelPlace find_place(const SparseVoxels& voxels, float x, float y, float z);

// The trilinear mean of the first `count` channels of a place that is stored.
void interpolate(const SparseVoxels& voxels, const VoxelPlace& place, int count, float* out);

// What is to be stored. places: in the unit cube, without directions.
struct VoxelSource {
  std::function<void(const FieldSamples& places, std::vector<float>& sigma)> densities;  // per cube side
  // (N, channels - 1): the further values of nodes.
  std::function<void(const FieldSamples& places, std::span<float> values)> values;
};

// Cells that hold the moved contents of occupied cells, and their neighbours. move: to the space that is
// stored, for view 0, 1, ...; a posed mouth's inside lies somewhere else there, and so may whatever a
// deformation moves.
OccupancyGrid moved_occupancy(const OccupancyGrid& posed, std::size_t views,
                              const std::function<void(FieldSamples& samples)>& move);

// A block is stored where it touches an occupied cell (an empty grid: all are) and where a cell of a node's
// density takes more than `least` of the light.
SparseVoxels bake_voxels(int resolution, int channels, const OccupancyGrid& occupancy,
                         const VoxelSource& source, float least = 1e-3f);

// The same with `more` channels after the existing ones; values as in VoxelSource, of the stored nodes only.
SparseVoxels with_channels(
    const SparseVoxels& voxels, int more,
    const std::function<void(const FieldSamples& places, std::span<float> values)>& values);

}  // namespace likeness
