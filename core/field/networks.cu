// The field's networks on a CUDA device: all layers of a tile of samples in one block, in shared memory.
// Products in bfloat16 run on the matrix units with sums in single precision; the single-precision ones in
// plain loops.
#include <cuda_bf16.h>
#include <mma.h>

#include "core/cuda/launch.h"
#include "core/field/network_math.h"

namespace likeness::cuda {
namespace {

namespace wmma = nvcuda::wmma;

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

struct SingleBlock : Threads, LoopProducts<SingleBlock> {};

#if __CUDA_ARCH__ >= 800
using Bf16 = __nv_bfloat16;

template <Order kOrder>
struct LayoutOf {
  using Type = wmma::row_major;
};
template <>
struct LayoutOf<Order::columns> {
  using Type = wmma::col_major;
};

struct MatrixBlock : Threads, PieceProducts<MatrixBlock> {
  using Sum = wmma::fragment<wmma::accumulator, 16, 16, 16, float>;

  __device__ int warp() const { return int(threadIdx.x) / 32; }
  __device__ int warps() const { return int(kBlockThreads) / 32; }
  __device__ float* staging() const { return reinterpret_cast<float*>(block_memory) + warp() * 256; }
  __device__ void sync() const { __syncthreads(); }
  __device__ void zero(Sum& sum) const { wmma::fill_fragment(sum, 0.0f); }
  template <Order kA, Order kB>
  __device__ void multiply(Sum& sum, const Bf16* a, int a_stride, const Bf16* b, int b_stride) const {
    wmma::fragment<wmma::matrix_a, 16, 16, 16, Bf16, typename LayoutOf<kA>::Type> left;
    wmma::fragment<wmma::matrix_b, 16, 16, 16, Bf16, typename LayoutOf<kB>::Type> right;
    wmma::load_matrix_sync(left, a, unsigned(a_stride));
    wmma::load_matrix_sync(right, b, unsigned(b_stride));
    wmma::mma_sync(sum, left, right, sum);
  }
  template <Order kOrder>
  __device__ void store(const Sum& sum, float* to) const {
    wmma::store_matrix_sync(to, sum, 16,
                            kOrder == Order::columns ? wmma::mem_col_major : wmma::mem_row_major);
  }
  template <class F>
  __device__ void for_lanes(int count, const F& f) const {
    __syncwarp();
#pragma unroll
    for (int e = int(threadIdx.x) % 32; e < count; e += 32) f(e);
    __syncwarp();
  }
};
#endif

template <bool kBackward>
__global__ void __launch_bounds__(kBlockThreads, 1) single_kernel(const __grid_constant__ NetworkArgs args) {
  SingleBlock block;
  if (kBackward)
    likeness::network_backward<float>(block, args, block_memory);
  else
    likeness::network_forward<float>(block, args, block_memory);
}

template <bool kBackward>
__global__ void __launch_bounds__(kBlockThreads, 1) matrix_kernel(const __grid_constant__ NetworkArgs args) {
#if __CUDA_ARCH__ >= 800
  MatrixBlock block;
  if (kBackward)
    likeness::network_backward<Bf16>(block, args, block_memory);
  else
    likeness::network_forward<Bf16>(block, args, block_memory);
#endif
}

// As many blocks as run at once: each keeps its weights and sums over all of its tiles.
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
  return args.precision == NetworkPrecision::bf16 ? queue(launch, matrix_kernel<false>, args, items, false)
                                                  : queue(launch, single_kernel<false>, args, items, false);
}

cudaError_t network_backward(const Launch& launch, const NetworkArgs& args, std::size_t items) {
  return args.precision == NetworkPrecision::bf16 ? queue(launch, matrix_kernel<true>, args, items, true)
                                                  : queue(launch, single_kernel<true>, args, items, true);
}

}  // namespace likeness::cuda
