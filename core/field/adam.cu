// Adam on a CUDA device: a thread a line of the tables or a parameter of the networks; the codes in one
// block.
#include "core/cuda/launch.h"
#include "core/field/device_math.h"

namespace likeness::cuda {
namespace {

constexpr unsigned kThreads = 256;

struct OneBlock {
  template <class F>
  __device__ void for_each(int count, const F& f) const {
    for (int i = int(threadIdx.x); i < count; i += int(blockDim.x)) f(i);
    __syncthreads();
  }
};

__global__ void __launch_bounds__(kThreads) lines_kernel(AdamLinesArgs args) {
  const std::uint32_t line = blockIdx.x * kThreads + threadIdx.x;
  if (line < args.lines) adam_line(args, line);
}

__global__ void __launch_bounds__(kThreads) networks_kernel(AdamNetworksArgs args) {
  const std::uint32_t item = blockIdx.x * kThreads + threadIdx.x;
  if (item < args.end - args.begin) adam_network(args, item);
}

__global__ void __launch_bounds__(kThreads, 1) codes_kernel(AdamCodesArgs args) {
  OneBlock block;
  likeness::adam_codes(block, args);
}

}  // namespace

cudaError_t adam_lines(const Launch& launch, const AdamLinesArgs& args, std::size_t items) {
  lines_kernel<<<blocks_of(items, kThreads), kThreads, 0, launch.stream>>>(args);
  return cudaGetLastError();
}

cudaError_t adam_networks(const Launch& launch, const AdamNetworksArgs& args, std::size_t items) {
  networks_kernel<<<blocks_of(items, kThreads), kThreads, 0, launch.stream>>>(args);
  return cudaGetLastError();
}

cudaError_t adam_codes(const Launch& launch, const AdamCodesArgs& args, std::size_t) {
  codes_kernel<<<1, kThreads, 0, launch.stream>>>(args);
  return cudaGetLastError();
}

}  // namespace likeness::cuda
