// Adam on a CUDA device: four threads per line of the tables, a thread per parameter of the networks; the
// codes in one block.
#include "core/field/cuda_launchers.h"
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

// adam_line by four threads, each of which has four of its values.
__global__ void __launch_bounds__(kThreads) lines_kernel(AdamLinesArgs args) {
  static_assert(kTableLine == 16);
  const std::uint32_t item = blockIdx.x * kThreads + threadIdx.x, line = item / 4, lane = threadIdx.x % 32;
  const bool there = line < args.lines;
  float4* const gradients = reinterpret_cast<float4*>(args.gradients) + item;
  const float4 g = there ? *gradients : make_float4(0, 0, 0, 0);
  const unsigned voters = __ballot_sync(~0u, g.x != 0 || g.y != 0 || g.z != 0 || g.w != 0);
  const bool any = (voters >> (lane & ~3u) & 15u) != 0;
  const bool moves = is_finite(args.sums->error);
  const std::uint32_t step = any && moves ? args.line_steps[line] + 1 : 0;
  __syncwarp();  // all have read it
  if (!any) return;
  if (moves) {
    const float rate = line_rate(args, step);
    float4 value = reinterpret_cast<float4*>(args.parameters)[item],
           first = reinterpret_cast<float4*>(args.first)[item],
           second = reinterpret_cast<float4*>(args.second)[item];
    adam_table_value(args, value.x, g.x, first.x, second.x, rate);
    adam_table_value(args, value.y, g.y, first.y, second.y, rate);
    adam_table_value(args, value.z, g.z, first.z, second.z, rate);
    adam_table_value(args, value.w, g.w, first.w, second.w, rate);
    reinterpret_cast<float4*>(args.parameters)[item] = value;
    reinterpret_cast<float4*>(args.first)[item] = first;
    reinterpret_cast<float4*>(args.second)[item] = second;
    if (lane % 4 == 0) args.line_steps[line] = step;
  }
  *gradients = make_float4(0, 0, 0, 0);
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
  lines_kernel<<<blocks_of(4 * items, kThreads), kThreads, 0, launch.stream>>>(args);
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
