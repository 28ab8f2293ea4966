// Look-ups in grids and their gradients on a CUDA device: a thread per sample and level, the samples of one
// level next to each other, so that the cache holds that level's table.
#include "core/field/cuda_launchers.h"
#include "core/field/grid_math.h"

namespace likeness::cuda {
namespace {

constexpr unsigned kThreads = 256;

// Batches of pictures have room for many more samples than they hold: blocks loop over samples, so that there
// need not be one for every place.
template <int kDims, int kFeatures>
__global__ void __launch_bounds__(kThreads) encode_kernel(const __grid_constant__ EncodeArgs args) {
  const std::uint32_t count = *args.count;
  for (std::uint32_t n = blockIdx.x * kThreads + threadIdx.x; n < count; n += gridDim.x * kThreads)
    encode_sample<kDims, kFeatures>(args, n, int(blockIdx.y));
}

// -- Gradients. Samples of a warp are neighbours on their rays and, in the coarse levels or where a slice
// hardly moves, in the same cell: their gradients are summed before they go to memory, where additions to one
// address are serialised.

constexpr int kMaxGroups = 6;  // cells of a warp for which it pays

// The sums over a warp of kCount values, a power of two up to 32; a lane gets that of value lane / (32 /
// kCount). Each step halves what a thread holds; sizes are compile-time constants, so that everything stays
// in registers.
template <int kLeft, int kBit, int kCount>
__device__ void sum_halves(float (&value)[kCount]) {
  if constexpr (kBit > 0) {
    constexpr int kHalf = kLeft > 1 ? kLeft / 2 : 1;
    if constexpr (kLeft == 1) {
      value[0] += __shfl_xor_sync(~0u, value[0], kBit);
    } else {
      const bool upper = (threadIdx.x & unsigned(kBit)) != 0;
#pragma unroll
      for (int k = 0; k < kHalf; ++k) {
        const float given = upper ? value[k] : value[k + kHalf], kept = upper ? value[k + kHalf] : value[k];
        value[k] = kept + __shfl_xor_sync(~0u, given, kBit);
      }
    }
    sum_halves<kHalf, kBit / 2>(value);
  }
}
template <int kCount>
__device__ float warp_sum(float (&value)[kCount]) {
  sum_halves<kCount, 16>(value);
  return value[0];
}

// By all threads of a warp; `there`: whether this one has a sample.
template <int kDims, int kFeatures, bool kSlopes>
__device__ void warp_backward(const EncodeBackwardArgs& args, std::size_t n, bool there, int l,
                              float* d_point) {
  constexpr int kCorners = 1 << kDims, kCount = kCorners * kFeatures;
  const GridLevel& level = args.grid.level[l];
  float gradient[kFeatures] = {};
  const bool any = there && level_gradient(args, n, l, gradient);
  const GridCell<kDims> cell(level, args.point, there ? n : 0);
  if (kSlopes && any) add_slopes(args, level, cell, gradient, d_point);
  bool direct = any;
  if constexpr (kCount <= 32) {
    const unsigned busy = __ballot_sync(~0u, any);
    if (busy == 0) return;
    std::uint32_t place = 0;
    for (int a = 0; a < kDims; ++a) place = place * 1024u + cell.vertex[a];
    const unsigned mates = __match_any_sync(~0u, any ? place : ~0u) & busy;
    const bool leads = any && __ffs(int(mates)) - 1 == int(threadIdx.x % 32);
    unsigned leaders = __ballot_sync(~0u, leads);
    if (level.resolution <= 1024 && __popc(leaders) <= kMaxGroups) {
      direct = false;
      while (leaders != 0) {
        const int leader = __ffs(int(leaders)) - 1;
        leaders &= leaders - 1;
        const std::uint32_t now = __shfl_sync(~0u, place, leader);
        const bool own = any && place == now;
        float value[kCount];
#pragma unroll
        for (int c = 0; c < kCorners; ++c) {
          const float weight = cell.weight(c);
          for (int f = 0; f < kFeatures; ++f) value[c * kFeatures + f] = own ? weight * gradient[f] : 0.0f;
        }
        const float sum = warp_sum(value);
        constexpr int kShare = 32 / kCount;
        const int lane = int(threadIdx.x % 32), c = lane / kShare / kFeatures, f = lane / kShare % kFeatures;
        std::uint32_t entry = 0;
#pragma unroll
        for (int k = 0; k < kCorners; ++k) {
          const std::uint32_t of_leader = __shfl_sync(~0u, cell.entry(level, k), leader);
          entry = k == c ? of_leader : entry;
        }
        if (lane % kShare == 0 && sum != 0)
          add_to(args.gradients + level.offset + std::size_t(entry) * kFeatures + std::size_t(f), sum);
      }
    }
  }
  if (direct) add_gradients(args, level, cell, gradient);
}

template <int kDims, int kFeatures>
__global__ void __launch_bounds__(kThreads) scatter_kernel(const __grid_constant__ EncodeBackwardArgs args) {
  const std::uint32_t n = blockIdx.x * kThreads + threadIdx.x;
  const bool there = n < *args.count;
  if (__any_sync(~0u, there))
    warp_backward<kDims, kFeatures, false>(args, n, there, int(blockIdx.y), nullptr);
}

template <int kDims, int kFeatures>
__global__ void __launch_bounds__(kThreads) slopes_kernel(const __grid_constant__ EncodeBackwardArgs args) {
  const std::uint32_t n = blockIdx.x * kThreads + threadIdx.x;
  const bool there = n < *args.count;
  if (!__any_sync(~0u, there)) return;
  float d_point[kDims] = {};
  // Blocks begin with different levels: otherwise all would add to the few cells of the coarsest at once.
  for (int k = 0; k < args.grid.levels; ++k)
    warp_backward<kDims, kFeatures, true>(
        args, n, there, int((unsigned(k) + blockIdx.x) % unsigned(args.grid.levels)), d_point);
  for (int a = 0; a < kDims && there; ++a) args.d_point[a][n] = d_point[a];
}

}  // namespace

cudaError_t encode(const Launch& launch, const EncodeArgs& args, std::size_t items) {
  constexpr unsigned kBlocksAtOnce = 16;
  const unsigned all = blocks_of(items / std::size_t(args.grid.levels), kThreads),
                 most = unsigned(launch.facts.multiprocessors) * kBlocksAtOnce;
  const dim3 blocks(all < most ? all : most, unsigned(args.grid.levels));
#define LIKENESS_ENCODE(D, F) encode_kernel<D, F><<<blocks, kThreads, 0, launch.stream>>>(args);
  LIKENESS_FOR_GRID(args.grid, LIKENESS_ENCODE)
#undef LIKENESS_ENCODE
  return cudaGetLastError();
}

cudaError_t encode_backward(const Launch& launch, const EncodeBackwardArgs& args, std::size_t) {
  const unsigned samples = blocks_of(args.capacity, kThreads);
  if (args.d_point[0]) {
#define LIKENESS_ENCODE(D, F) slopes_kernel<D, F><<<samples, kThreads, 0, launch.stream>>>(args);
    LIKENESS_FOR_GRID(args.grid, LIKENESS_ENCODE)
#undef LIKENESS_ENCODE
  } else {
    const dim3 blocks(samples, unsigned(args.grid.levels));
#define LIKENESS_ENCODE(D, F) scatter_kernel<D, F><<<blocks, kThreads, 0, launch.stream>>>(args);
    LIKENESS_FOR_GRID(args.grid, LIKENESS_ENCODE)
#undef LIKENESS_ENCODE
  }
  return cudaGetLastError();
}

cudaError_t has_code() {
  cudaFuncAttributes attributes;
  return cudaFuncGetAttributes(&attributes, encode_kernel<3, 4>);
}

}  // namespace likeness::cuda
