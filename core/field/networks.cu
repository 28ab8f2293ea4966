// The field's networks on a CUDA device: all layers of a tile of samples in one block, in shared memory, in
// plain loops. The usual networks in bfloat16 go through matrix_networks.cu instead.
#include <cuda_bf16.h>

#include "core/field/cuda_launchers.h"
#include "core/field/network_math.h"

namespace likeness::cuda {
namespace {

extern __shared__ __align__(128) unsigned char block_memory[];

struct Threads {
  __device__ std::uint32_t index() const { return blockIdx.x; }
  __device__ std::uint32_t blocks() const { return gridDim.x; }
  template <class F>
  __device__ void for_each(int count, const F& f) const {
    for (int i = int(threadIdx.x); i < count; i += int(blockDim.x)) f(i);
    __syncthreads();
  }
};

struct LoopBlock : Threads, LoopProducts<LoopBlock> {};

template <class Value, bool kBackward>
__global__ void __launch_bounds__(kBlockThreads, 1) loop_kernel(const __grid_constant__ NetworkArgs args) {
  LoopBlock block;
  if (kBackward)
    likeness::network_backward<Value>(block, args, block_memory);
  else
    likeness::network_forward<Value>(block, args, block_memory);
}

// As many blocks as can run at once: each keeps its weights and sums over all of its tiles.
template <class KernelFunction>
cudaError_t queue(const Launch& launch, KernelFunction kernel, const NetworkArgs& args, std::size_t items,
                  bool backward) {
  const std::size_t value = args.precision == NetworkPrecision::bf16 ? 2 : 4;
  const std::size_t shared = network_memory(args, value, backward).end;
  cudaError_t failed = cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, int(shared));
  if (failed != cudaSuccess) return failed;
  int at_once = 0;
  failed = cudaOccupancyMaxActiveBlocksPerMultiprocessor(&at_once, kernel, int(kBlockThreads), shared);
  if (failed != cudaSuccess) return failed;
  const unsigned tiles = blocks_of(items, unsigned(args.rows));
  const unsigned most = unsigned(launch.facts.multiprocessors) * unsigned(at_once > 0 ? at_once : 1);
  const unsigned blocks = tiles < most ? tiles : most;
  kernel<<<blocks, unsigned(kBlockThreads), shared, launch.stream>>>(args);
  return cudaGetLastError();
}

}  // namespace

cudaError_t network_forward(const Launch& launch, const NetworkArgs& args, std::size_t items) {
  bool taken = false;
  const cudaError_t failed = matrix_network(launch, args, items, false, taken);
  if (failed != cudaSuccess || taken) return failed;
  return args.precision == NetworkPrecision::bf16
             ? queue(launch, loop_kernel<__nv_bfloat16, false>, args, items, false)
             : queue(launch, loop_kernel<float, false>, args, items, false);
}

cudaError_t network_backward(const Launch& launch, const NetworkArgs& args, std::size_t items) {
  bool taken = false;
  const cudaError_t failed = matrix_network(launch, args, items, true, taken);
  if (failed != cudaSuccess || taken) return failed;
  return args.precision == NetworkPrecision::bf16
             ? queue(launch, loop_kernel<__nv_bfloat16, true>, args, items, true)
             : queue(launch, loop_kernel<float, true>, args, items, true);
}

}  // namespace likeness::cuda
