// Kernels that measure a device's peak rates: lower bounds for the times of the field's kernels. Plain C++17.
#pragma once

#include <cstddef>
#include <cstdint>

namespace likeness {

// read_write: out[i] = in[i] + 1 over items of 16 bytes; every item moves 32 bytes. matrix_rate: each item, a
// warp, multiplies `repeats` times kMatrixChains independent 16 x 16 matrices in bfloat16 (compute capability
// 8.0), 8192 operations each; one sum per warp goes to `out`, so that nothing can be optimised away.
constexpr int kMatrixChains = 4;
struct CeilingArgs {
  const float* in;  // (4 items)
  float* out;       // (4 items); of matrix_rate (items)
  std::int32_t repeats;
};

}  // namespace likeness
