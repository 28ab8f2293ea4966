// bf16 dot products by intrinsics, which Highway 1.0 does not know: see bf16_ceiling.h.
#include "core/bench/bf16_ceiling.h"

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>

#include <algorithm>
#include <cstddef>

#include "core/bench/stopwatch.h"
#endif

namespace likeness {

#if defined(__x86_64__) && defined(__GNUC__)

namespace {

constexpr int kChains = 12;
constexpr std::size_t kRounds = 4096;
constexpr double kOperations = 16 * 4;  // an instruction: 16 lanes, two products and two sums each

__attribute__((target("avx512f,avx512bf16"), noinline)) float dot_block(float start) {
  __m512 sum[kChains];
#pragma GCC unroll 12
  for (int k = 0; k < kChains; ++k) sum[k] = _mm512_set1_ps(start + float(k));
  const __m512bh one = (__m512bh)_mm512_set1_epi32(0x3f803f80),
                 small = (__m512bh)_mm512_set1_epi32(0x38003800);
  for (std::size_t r = 0; r < kRounds; ++r) {
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

std::optional<double> measure_bf16_gflops(double seconds) {
  if (!__builtin_cpu_supports("avx512bf16")) return std::nullopt;
  double best = 0;
  // Each block starts from what the one before gave: one that is the same every time would be computed once.
  volatile float keep = dot_block(0);
  for (const Stopwatch all(1); all.seconds() < seconds;) {
    const Stopwatch watch(1);
    keep = dot_block(0.01f * keep);
    best = std::max(best, 1e-9 * kOperations * kChains * double(kRounds) / watch.seconds());
  }
  return best;
}

#else

std::optional<double> measure_bf16_gflops(double) { return std::nullopt; }

#endif

}  // namespace likeness
