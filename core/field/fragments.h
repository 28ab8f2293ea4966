// Pieces of matrices in the registers of a warp, for the matrix units of CUDA devices of compute
// capability 8.0 and later (PTX ISA, mma.m16n8k16 and ldmatrix). Products of bfloat16, sums in single
// precision.
//
// g and t name a thread: its lane is 4 g + t. A Piece is 16 x 16: a thread holds (row, columns 2t and 2t + 1)
// of rows g and g + 8, then the same of columns 8 + 2t. Sums are 16 x 8: (g, 2t), (g, 2t + 1), (g + 8, 2t),
// (g + 8, 2t + 1). So two adjacent sums, rounded, are a piece: the next layer reads one layer's outputs
// without going through memory.
#pragma once

#include <cuda_bf16.h>

#include <cstdint>

namespace likeness::cuda {

using Bf16 = __nv_bfloat16;

struct Piece {
  std::uint32_t part[4];
};
struct Sums {
  float value[4];
};

__device__ inline int lane_id() { return int(threadIdx.x) % 32; }

__device__ inline std::uint32_t rounded_pair(float first, float second) {
  const __nv_bfloat162 pair = __floats2bfloat162_rn(first, second);
  return reinterpret_cast<const std::uint32_t&>(pair);
}
// Their rounding errors, rounded.
__device__ inline std::uint32_t rounded_rest(float first, float second) {
  return rounded_pair(first - __bfloat162float(__float2bfloat16_rn(first)),
                      second - __bfloat162float(__float2bfloat16_rn(second)));
}

// Four matrices of 8 x 8, whose rows of 16 bytes are at the addresses given by lanes 0-7, 8-15, 16-23 and
// 24-31.
template <bool kTransposed>
__device__ inline void load_four(std::uint32_t (&to)[4], const Bf16* row) {
  const auto at = std::uint32_t(__cvta_generic_to_shared(row));
  if (kTransposed)
    asm volatile("ldmatrix.sync.aligned.m8n8.x4.trans.shared.b16 {%0, %1, %2, %3}, [%4];"
                 : "=r"(to[0]), "=r"(to[1]), "=r"(to[2]), "=r"(to[3])
                 : "r"(at)
                 : "memory");
  else
    asm volatile("ldmatrix.sync.aligned.m8n8.x4.shared.b16 {%0, %1, %2, %3}, [%4];"
                 : "=r"(to[0]), "=r"(to[1]), "=r"(to[2]), "=r"(to[3])
                 : "r"(at)
                 : "memory");
}

// Ways to load the matrix at m, rows `stride` apart. Left: (16, 16) as it is.
struct AsLeft {
  __device__ static Piece load(const Bf16* m, int stride) {
    const int lane = lane_id();
    Piece piece;
    load_four<false>(piece.part, m + lane % 16 * stride + lane / 16 * 8);
    return piece;
  }
};
// Its transpose.
struct AsLeftTransposed {
  __device__ static Piece load(const Bf16* m, int stride) {
    const int lane = lane_id();
    Piece piece;
    load_four<true>(piece.part, m + (lane % 8 + lane / 16 * 8) * stride + lane / 8 % 2 * 8);
    return piece;
  }
};
__device__ inline void store_piece(const Piece& piece, Bf16* m, int stride) {
  const int g = lane_id() / 4, t = lane_id() % 4;
#pragma unroll
  for (int k = 0; k < 4; ++k)
    *reinterpret_cast<std::uint32_t*>(m + (g + k % 2 * 8) * stride + k / 2 * 8 + 2 * t) = piece.part[k];
}

// The right factors of a product, for two adjacent sums: parts 0 and 1 are for the first. Weights (16
// outputs, 16 inputs), so that sums are of outputs.
struct ToOutputs {
  __device__ static Piece load(const Bf16* m, int stride) {
    const int lane = lane_id();
    Piece piece;
    load_four<false>(piece.part, m + (lane / 16 * 8 + lane % 8) * stride + lane / 8 % 2 * 8);
    return piece;
  }
};
// The same weights, so that sums are of inputs.
struct ToInputs {
  __device__ static Piece load(const Bf16* m, int stride) {
    const int lane = lane_id();
    Piece piece;
    load_four<true>(piece.part, m + lane % 16 * stride + lane / 16 * 8);
    return piece;
  }
};
// (32, 8), for two products over 16 rows each: parts 0 and 1 are for the first.
struct Of32Rows {
  __device__ static Piece load(const Bf16* m, int stride) {
    Piece piece;
    load_four<true>(piece.part, m + lane_id() * stride);
    return piece;
  }
};

// sums += left * right
__device__ inline void multiply(Sums& sums, const Piece& left, std::uint32_t right0, std::uint32_t right1) {
  asm volatile(
      "mma.sync.aligned.m16n8k16.row.col.f32.bf16.bf16.f32 {%0, %1, %2, %3}, {%4, %5, %6, %7}, {%8, %9}, "
      "{%0, "
      "%1, %2, %3};"
      : "+f"(sums.value[0]), "+f"(sums.value[1]), "+f"(sums.value[2]), "+f"(sums.value[3])
      : "r"(left.part[0]), "r"(left.part[1]), "r"(left.part[2]), "r"(left.part[3]), "r"(right0), "r"(right1));
}

}  // namespace likeness::cuda
