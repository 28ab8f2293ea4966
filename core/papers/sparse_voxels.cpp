// Storing and looking up: see sparse_voxels.h.
#include "core/papers/sparse_voxels.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace likeness {
namespace {

// Whether a cell of the occupancy grid that overlaps the block is occupied.
bool may_hold(const OccupancyGrid& occupancy, int blocks, int bx, int by, int bz) {
  if (occupancy.resolution == 0) return true;
  const int n = occupancy.resolution;
  const auto first = [&](int b) { return b * n / blocks; };
  const auto last = [&](int b) { return std::min(n - 1, ((b + 1) * n + blocks - 1) / blocks - 1); };
  for (int z = first(bz); z <= last(bz); ++z)
    for (int y = first(by); y <= last(by); ++y)
      for (int x = first(bx); x <= last(bx); ++x)
        if (occupancy.occupied(x, y, z)) return true;
  return false;
}

struct BlockAt {
  int x = 0, y = 0, z = 0;
};

// All nodes of blocks, one block after the other.
FieldSamples nodes_of(std::span<const BlockAt> blocks, int resolution) {
  FieldSamples places;
  places.resize(blocks.size() * kNodesOfBlock);
  const float cell = 1.f / float(resolution);
  parallel_ranges(blocks.size(), 16, [&](std::size_t begin, std::size_t end) {
    std::size_t i = begin * kNodesOfBlock;
    for (std::size_t b = begin; b < end; ++b)
      for (int z = 0; z < kVoxelNodes; ++z)
        for (int y = 0; y < kVoxelNodes; ++y)
          for (int x = 0; x < kVoxelNodes; ++x, ++i) {
            places.x[i] = cell * float(blocks[b].x * kVoxelBlock + x);
            places.y[i] = cell * float(blocks[b].y * kVoxelBlock + y);
            places.z[i] = cell * float(blocks[b].z * kVoxelBlock + z);
            places.dx[i] = places.dy[i] = 0, places.dz[i] = 1;
            places.view[i] = 0;
          }
  });
  return places;
}

}  // namespace

VoxelPlace find_place(const SparseVoxels& voxels, float x, float y, float z) {
  const float n = float(voxels.resolution);
  const int most = voxels.resolution - 1, blocks = voxels.resolution / kVoxelBlock;
  const float at[] = {x * n, y * n, z * n};
  int cell[3];
  float part[3];
  for (int a = 0; a < 3; ++a) {
    if (!(at[a] >= 0 && at[a] <= n)) return {};
    cell[a] = std::min(int(at[a]), most);
    part[a] = at[a] - float(cell[a]);
  }
  const std::int32_t block = voxels.blocks[(std::size_t(cell[2] / kVoxelBlock) * std::size_t(blocks) +
                                            std::size_t(cell[1] / kVoxelBlock)) *
                                               std::size_t(blocks) +
                                           std::size_t(cell[0] / kVoxelBlock)];
  if (block < 0) return {};
  const std::size_t node =
      (std::size_t(cell[2] % kVoxelBlock) * kVoxelNodes + std::size_t(cell[1] % kVoxelBlock)) * kVoxelNodes +
      std::size_t(cell[0] % kVoxelBlock);
  return {voxels.nodes.data() + (std::size_t(block) * kNodesOfBlock + node) * std::size_t(voxels.channels),
          part[0], part[1], part[2]};
}

void interpolate(const SparseVoxels& voxels, const VoxelPlace& place, int count, float* out) {
  const auto c = std::size_t(voxels.channels);
  const float* corners[8];
  float weights[8];
  for (std::size_t k = 0; k < 8; ++k) {
    corners[k] =
        place.node + ((k & 4 ? kVoxelNodes * kVoxelNodes : 0) + (k & 2 ? kVoxelNodes : 0) + (k & 1)) * c;
    weights[k] =
        (k & 1 ? place.x : 1 - place.x) * (k & 2 ? place.y : 1 - place.y) * (k & 4 ? place.z : 1 - place.z);
  }
  if (count == 8) {  // of a baked head: in vectors
    using Values = Eigen::Array<float, 8, 1>;
    Values sum = Values::Zero();
    for (std::size_t k = 0; k < 8; ++k) sum += weights[k] * Eigen::Map<const Values>(corners[k]);
    Eigen::Map<Values>{out} = sum;
    return;
  }
  for (int i = 0; i < count; ++i) out[i] = 0;
  for (std::size_t k = 0; k < 8; ++k)
    for (int i = 0; i < count; ++i) out[i] += weights[k] * corners[k][i];
}

OccupancyGrid moved_occupancy(const OccupancyGrid& posed, std::size_t views,
                              const std::function<void(FieldSamples& samples)>& move) {
  const int n = posed.resolution;
  if (n == 0) return posed;
  FieldSamples places;  // eight of each occupied cell
  for (int z = 0; z < 2 * n; ++z)
    for (int y = 0; y < 2 * n; ++y)
      for (int x = 0; x < 2 * n; ++x) {
        if (!posed.occupied(x / 2, y / 2, z / 2)) continue;
        const float half = 0.5f / float(n);
        places.x.push_back(half * (float(x) + 0.5f));
        places.y.push_back(half * (float(y) + 0.5f));
        places.z.push_back(half * (float(z) + 0.5f));
      }
  const std::size_t count = places.x.size();
  places.dx.assign(count, 0), places.dy.assign(count, 0), places.dz.assign(count, 1);
  OccupancyGrid met = make_occupancy(n, false), moved = met;
  for (std::size_t v = 0; v < views; ++v) {
    FieldSamples there = places;
    there.view.assign(count, std::int32_t(v));
    move(there);
    for (std::size_t i = 0; i < count; ++i) {
      const auto cell = [n](float at) { return std::clamp(int(at * float(n)), 0, n - 1); };
      set_occupied(met, cell(there.x[i]), cell(there.y[i]), cell(there.z[i]), true);
    }
  }
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        if (!met.occupied(x, y, z)) continue;
        for (int w = std::max(0, z - 1); w <= std::min(n - 1, z + 1); ++w)
          for (int v = std::max(0, y - 1); v <= std::min(n - 1, y + 1); ++v)
            for (int u = std::max(0, x - 1); u <= std::min(n - 1, x + 1); ++u)
              set_occupied(moved, u, v, w, true);
      }
  return moved;
}

SparseVoxels bake_voxels(int resolution, int channels, const OccupancyGrid& occupancy,
                         const VoxelSource& source, float least) {
  LIKENESS_CHECK(resolution > 0 && resolution % kVoxelBlock == 0 && channels > 0, "%d cells of %d channels",
                 resolution, channels);
  const int n = resolution / kVoxelBlock;
  SparseVoxels voxels{resolution, channels, {}, {}};
  voxels.blocks.assign(std::size_t(n) * std::size_t(n) * std::size_t(n), -1);
  const float floor = -std::log1p(-least) * float(resolution);  // density of a cell that takes this much
  const auto c = std::size_t(channels);
  for (int bz = 0; bz < n; ++bz) {  // a layer of blocks at once
    std::vector<BlockAt> candidates;
    for (int by = 0; by < n; ++by)
      for (int bx = 0; bx < n; ++bx)
        if (may_hold(occupancy, n, bx, by, bz)) candidates.push_back({bx, by, bz});
    if (candidates.empty()) continue;
    const FieldSamples places = nodes_of(candidates, resolution);
    std::vector<float> sigma;
    source.densities(places, sigma);
    std::vector<std::size_t> kept;
    std::vector<BlockAt> kept_at;
    for (std::size_t b = 0; b < candidates.size(); ++b) {
      const auto own = std::span<const float>(sigma).subspan(b * kNodesOfBlock, kNodesOfBlock);
      if (*std::ranges::max_element(own) > floor) kept.push_back(b), kept_at.push_back(candidates[b]);
    }
    if (kept.empty()) continue;
    std::vector<float> values(kept.size() * kNodesOfBlock * (c - 1));
    if (channels > 1) source.values(nodes_of(kept_at, resolution), values);
    std::size_t block = voxels.stored_blocks();
    voxels.nodes.resize(voxels.nodes.size() + kept.size() * kNodesOfBlock * c);
    for (std::size_t k = 0; k < kept.size(); ++k, ++block) {
      const BlockAt& at = kept_at[k];
      voxels.blocks[(std::size_t(at.z) * std::size_t(n) + std::size_t(at.y)) * std::size_t(n) +
                    std::size_t(at.x)] = std::int32_t(block);
      for (std::size_t i = 0; i < kNodesOfBlock; ++i) {
        float* node = voxels.nodes.data() + (block * kNodesOfBlock + i) * c;
        node[0] = sigma[kept[k] * kNodesOfBlock + i];
        std::copy_n(values.data() + (k * kNodesOfBlock + i) * (c - 1), c - 1, node + 1);
      }
    }
  }
  return voxels;
}

SparseVoxels with_channels(
    const SparseVoxels& voxels, int more,
    const std::function<void(const FieldSamples& places, std::span<float> values)>& values) {
  constexpr std::size_t kAtOnce = 256;  // blocks
  SparseVoxels out{voxels.resolution, voxels.channels + more, voxels.blocks, {}};
  const auto from = std::size_t(voxels.channels), to = std::size_t(out.channels);
  const int n = voxels.resolution / kVoxelBlock;
  std::vector<BlockAt> stored(voxels.stored_blocks());
  for (std::size_t i = 0; i < voxels.blocks.size(); ++i)
    if (voxels.blocks[i] >= 0)
      stored[std::size_t(voxels.blocks[i])] = {int(i) % n, int(i) / n % n, int(i) / n / n};
  out.nodes.resize(voxels.nodes.size() / from * to);
  std::vector<float> added;
  for (std::size_t first = 0; first < stored.size(); first += kAtOnce) {
    const std::size_t blocks = std::min(kAtOnce, stored.size() - first);
    added.resize(blocks * kNodesOfBlock * std::size_t(more));
    values(nodes_of(std::span(stored).subspan(first, blocks), voxels.resolution), added);
    for (std::size_t k = 0; k < blocks * kNodesOfBlock; ++k) {
      const std::size_t node = first * kNodesOfBlock + k;
      std::copy_n(voxels.nodes.data() + node * from, from, out.nodes.data() + node * to);
      std::copy_n(added.data() + k * std::size_t(more), more, out.nodes.data() + node * to + from);
    }
  }
  return out;
}

}  // namespace likeness
