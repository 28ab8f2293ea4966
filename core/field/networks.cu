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
template <class Use, class Layout>
using Matrix = wmma::fragment<Use, 16, 16, 16, Bf16, Layout>;
using Sum = wmma::fragment<wmma::accumulator, 16, 16, 16, float>;

// 16 x 16 pieces of a product, each by one warp. A piece's sums pass through the warp's staging memory, so
// that every lane knows which of them it holds.
struct MatrixBlock : Threads {
  // piece(first, second, sum): the sums of rows `first`.. and columns `second`..; emit(row, column, value).
  // Rows beside each other lie beside each other in `staging` when kColumns, else columns do.
  template <bool kColumns, class Piece, class Emit>
  __device__ void pieces(int rows, int columns, const Piece& piece, const Emit& emit) const {
    const int warp = int(threadIdx.x) / 32, lane = int(threadIdx.x) % 32;
    float* staging = reinterpret_cast<float*>(block_memory) + warp * 256;
    for (int p = warp; p < rows / 16 * (columns / 16); p += int(kBlockThreads) / 32) {
      const int first = p % (rows / 16) * 16, second = p / (rows / 16) * 16;
      Sum sum;
      wmma::fill_fragment(sum, 0.0f);
      piece(first, second, sum);
      wmma::store_matrix_sync(staging, sum, 16, kColumns ? wmma::mem_col_major : wmma::mem_row_major);
      __syncwarp();
#pragma unroll
      for (int e = lane; e < 256; e += 32) {
        const int fast = e % 16, slow = e / 16;
        emit(first + (kColumns ? fast : slow), second + (kColumns ? slow : fast), staging[e]);
      }
      __syncwarp();
    }
    __syncthreads();
  }

  template <class Finish>
  __device__ void product(const Bf16* in, const Bf16* weights, int stride, int inputs, int outputs, int rows,
                          int row, const Finish& finish) const {
    pieces<true>(
        rows, outputs,
        [&](int r, int o, Sum& sum) {
          for (int i = 0; i < inputs; i += 16) {
            Matrix<wmma::matrix_a, wmma::col_major> a;
            Matrix<wmma::matrix_b, wmma::col_major> b;
            wmma::load_matrix_sync(a, in + i * row + r, unsigned(row));
            wmma::load_matrix_sync(b, weights + o * stride + i, unsigned(stride));
            wmma::mma_sync(sum, a, b, sum);
          }
        },
        [&](int r, int o, float value) { finish(o, r, value); });
  }

  template <class Finish>
  __device__ void product_transposed(const Bf16* gradient, const Bf16* weights, int stride, int inputs,
                                     int outputs, int rows, int row, const Finish& finish) const {
    pieces<true>(
        rows, inputs,
        [&](int r, int i, Sum& sum) {
          for (int o = 0; o < outputs; o += 16) {
            Matrix<wmma::matrix_a, wmma::col_major> a;
            Matrix<wmma::matrix_b, wmma::row_major> b;
            wmma::load_matrix_sync(a, gradient + o * row + r, unsigned(row));
            wmma::load_matrix_sync(b, weights + o * stride + i, unsigned(stride));
            wmma::mma_sync(sum, a, b, sum);
          }
        },
        [&](int r, int i, float value) { finish(i, r, value); });
  }

  template <class Add>
  __device__ void outer(const Bf16* gradient, const Bf16* in, int inputs, int outputs, int rows, int row,
                        const Add& add) const {
    pieces<false>(
        outputs, inputs,
        [&](int o, int i, Sum& sum) {
          for (int r = 0; r < rows; r += 16) {
            Matrix<wmma::matrix_a, wmma::row_major> a;
            Matrix<wmma::matrix_b, wmma::col_major> b;
            wmma::load_matrix_sync(a, gradient + o * row + r, unsigned(row));
            wmma::load_matrix_sync(b, in + i * row + r, unsigned(row));
            wmma::mma_sync(sum, a, b, sum);
          }
        },
        add);
  }
};
#endif

template <bool kBackward>
__global__ void __launch_bounds__(kBlockThreads) single_kernel(const __grid_constant__ NetworkArgs args) {
  SingleBlock block;
  if (kBackward)
    likeness::network_backward<float>(block, args, block_memory);
  else
    likeness::network_forward<float>(block, args, block_memory);
}

template <bool kBackward>
__global__ void __launch_bounds__(kBlockThreads) matrix_kernel(const __grid_constant__ NetworkArgs args) {
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
  kernel < <<tiles<most ? tiles : most, unsigned(kBlockThreads), shared, launch.stream>>>(args);
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
