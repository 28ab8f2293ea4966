// Shared by the kernels with intrinsics (AVX-512 BF16). Functions between LIKENESS_BF16_BEGIN and
// LIKENESS_BF16_END are compiled for such processors; nothing of the standard library may be used there.
// Internal to core/field.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__)
#define LIKENESS_BF16_KERNELS 1
#include <immintrin.h>

#include <cstddef>

// clang-format off
#ifdef __clang__
#define LIKENESS_BF16_BEGIN \
  _Pragma("clang attribute push(__attribute__((target(\"avx2,fma,avx512f,avx512bw,avx512vl,avx512dq,avx512bf16\"))), apply_to = function)")
#define LIKENESS_BF16_END _Pragma("clang attribute pop")
#else
#define LIKENESS_BF16_BEGIN \
  _Pragma("GCC push_options") _Pragma("GCC target(\"avx2,fma,avx512f,avx512bw,avx512vl,avx512dq,avx512bf16\")")
#define LIKENESS_BF16_END _Pragma("GCC pop_options")
#endif
// clang-format on

LIKENESS_BF16_BEGIN
namespace likeness::bf16 {

inline constexpr std::size_t kWide = 16;  // lanes

inline __m512i bits_of(__m512bh v) { return (__m512i)v; }
inline __m512bh pairs_of(__m512i v) { return (__m512bh)v; }

// Words (first | second << 16) of two vectors, rounded.
inline __m512i paired(__m512 first, __m512 second) {
  const __m512i apart = bits_of(_mm512_cvtne2ps_pbh(second, first));
  const __m512i order = _mm512_set_epi16(31, 15, 30, 14, 29, 13, 28, 12, 27, 11, 26, 10, 25, 9, 24, 8, 23, 7,
                                         22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0);
  return _mm512_permutexvar_epi16(order, apart);
}

}  // namespace likeness::bf16
LIKENESS_BF16_END
#endif
