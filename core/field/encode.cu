// Look-ups in grids and their gradients on a CUDA device: a thread a sample and level, the samples of one
// level beside each other, so that a level's table is what the cache holds.
#include "core/cuda/launch.h"
#include "core/field/grid_math.h"

namespace likeness::cuda {
namespace {

constexpr unsigned kThreads = 256;

template <int kDims, int kFeatures>
__global__ void __launch_bounds__(kThreads) encode_kernel(const __grid_constant__ EncodeArgs args) {
  const std::uint32_t n = blockIdx.x * kThreads + threadIdx.x;
  if (n < *args.count) encode_sample<kDims, kFeatures>(args, n, int(blockIdx.y));
}

template <int kDims, int kFeatures>
__global__ void __launch_bounds__(kThreads) scatter_kernel(const __grid_constant__ EncodeBackwardArgs args) {
  const std::uint32_t n = blockIdx.x * kThreads + threadIdx.x;
  if (n < *args.count) encode_sample_backward<kDims, kFeatures, false>(args, n, int(blockIdx.y), nullptr);
}

template <int kDims, int kFeatures>
__global__ void __launch_bounds__(kThreads) slopes_kernel(const __grid_constant__ EncodeBackwardArgs args) {
  const std::uint32_t n = blockIdx.x * kThreads + threadIdx.x;
  if (n < *args.count) encode_sample_slopes<kDims, kFeatures>(args, n);
}

}  // namespace

cudaError_t encode(const Launch& launch, const EncodeArgs& args, std::size_t items) {
  const dim3 blocks(blocks_of(items / std::size_t(args.grid.levels), kThreads), unsigned(args.grid.levels));
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
