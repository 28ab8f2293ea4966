// bf16 dot products by intrinsics, which Highway 1.0 does not know: see ceiling_kernels.h.
#include "core/lab/bench/ceiling_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#endif

namespace likeness {

#if defined(__x86_64__) && defined(__GNUC__)

namespace {

constexpr int kChains = 12;
constexpr double kOperations = 16 * 4;  // per instruction: 16 lanes, two products and two sums each

__attribute__((target("avx512f,avx512bf16"), noinline)) float dot_block(std::size_t rounds, float start) {
  __m512 sum[kChains];
#pragma GCC unroll 12
  for (int k = 0; k < kChains; ++k) sum[k] = _mm512_set1_ps(start + float(k));
  const __m512bh one = (__m512bh)_mm512_set1_epi32(0x3f803f80),
                 small = (__m512bh)_mm512_set1_epi32(0x38003800);
  for (std::size_t r = 0; r < rounds; ++r) {
#pragma GCC unroll 12
    for (int k = 0; k < kChains; ++k) sum[k] = _mm512_dpbf16_ps(sum[k], one, small);
  }
#pragma GCC unroll 11
  for (int k = 1; k < kChains; ++k) sum[0] = _mm512_add_ps(sum[0], sum[k]);
  float lanes[16];
  _mm512_storeu_ps(lanes, sum[0]);
  return lanes[0];
}

}  // namespace

double bf16_block(std::size_t rounds, float& keep) {
  if (!__builtin_cpu_supports("avx512bf16")) return 0;
  // Each block starts from the result before it: the compiler would compute equal blocks only once.
  keep = dot_block(rounds, 0.01f * keep);
  return kOperations * kChains * double(rounds);
}

#else

double bf16_block(std::size_t, float&) { return 0; }

#endif

}  // namespace likeness
