// Rounding tables, and look-ups in them, with intrinsics: see field_bf16.h.
#include <algorithm>

#include "core/base/check.h"
#include "core/field/bf16_intrinsics.h"
#include "core/field/field_bf16.h"
#include "core/field/field_kernels.h"

namespace likeness {

#ifdef LIKENESS_BF16_KERNELS

LIKENESS_BF16_BEGIN

using namespace bf16;

namespace {

// The cells of a tile. A pair of corners that are neighbours in x: their entries' first features within the
// level, and their weights as one word.
struct CellPairs {
  alignas(64) std::uint32_t entry[8][kTile];
  alignas(64) std::uint32_t weights[4][kTile];
};

template <int kDims>
__attribute__((noinline)) void cell_pairs(const GridLevel& level, int features, const float* const* point,
                                          CellPairs& cells) {
  const auto width = std::uint32_t(features);
  const __m512i mask = _mm512_set1_epi32(int(level.mask * width));
  const __m512 zero = _mm512_setzero_ps(), one = _mm512_set1_ps(1.0f);
  const __m512 resolution = _mm512_set1_ps(float(level.resolution));
  const __m512i last = _mm512_set1_epi32(level.resolution - 1);
  for (std::size_t s = 0; s < kTile; s += kWide) {
    __m512 weight[3][2];
    __m512i key[3][2];
#pragma GCC unroll 3
    for (int a = 0; a < kDims; ++a) {
      const __m512 x = _mm512_loadu_ps(point[a] + s);
      const __m512 p = _mm512_mul_ps(_mm512_min_ps(_mm512_max_ps(x, zero), one), resolution);
      const __m512i cell = _mm512_min_epi32(_mm512_cvttps_epi32(p), last);
      weight[a][1] = _mm512_sub_ps(p, _mm512_cvtepi32_ps(cell));
      weight[a][0] = _mm512_sub_ps(one, weight[a][1]);
      const __m512i factor = _mm512_set1_epi32(int((level.hashed ? kHashPrime[a] : level.stride[a]) * width));
      key[a][0] = _mm512_mullo_epi32(cell, factor);
      key[a][1] = _mm512_add_epi32(key[a][0], factor);
    }
#pragma GCC unroll 4
    for (int c = 0; c < 1 << (kDims - 1); ++c) {  // corners along the other axes
      __m512 rest = one;
      __m512i low = key[0][0], high = key[0][1];
#pragma GCC unroll 2
      for (int a = 1; a < kDims; ++a) {
        const int side = c >> (a - 1) & 1;
        rest = a == 1 ? weight[a][side] : _mm512_mul_ps(rest, weight[a][side]);
        low = level.hashed ? _mm512_xor_si512(low, key[a][side]) : _mm512_add_epi32(low, key[a][side]);
        high = level.hashed ? _mm512_xor_si512(high, key[a][side]) : _mm512_add_epi32(high, key[a][side]);
      }
      if (level.hashed) low = _mm512_and_si512(low, mask), high = _mm512_and_si512(high, mask);
      _mm512_store_si512(&cells.entry[2 * c][s], low);
      _mm512_store_si512(&cells.entry[2 * c + 1][s], high);
      _mm512_store_si512(&cells.weights[c][s],
                         paired(_mm512_mul_ps(weight[0][0], rest), _mm512_mul_ps(weight[0][1], rest)));
    }
  }
}

// Rows of four features from the four samples' features.
inline void store_quads(const __m128 (&sample)[4], float* rows) {
  const __m128 low01 = _mm_unpacklo_ps(sample[0], sample[1]), low23 = _mm_unpacklo_ps(sample[2], sample[3]);
  const __m128 high01 = _mm_unpackhi_ps(sample[0], sample[1]), high23 = _mm_unpackhi_ps(sample[2], sample[3]);
  _mm_store_ps(rows, _mm_movelh_ps(low01, low23));
  _mm_store_ps(rows + kTile, _mm_movehl_ps(low23, low01));
  _mm_store_ps(rows + 2 * kTile, _mm_movelh_ps(high01, high23));
  _mm_store_ps(rows + 3 * kTile, _mm_movehl_ps(high23, high01));
}

template <int kPairs>
__attribute__((noinline)) void gather_quads(const std::uint16_t* table, const CellPairs& cells, float* rows) {
  for (std::size_t s = 0; s < kTile; s += 4) {
    __m128 sum[4];
#pragma GCC unroll 4
    for (std::size_t k = 0; k < 4; ++k) {
      sum[k] = _mm_setzero_ps();
#pragma GCC unroll 4
      for (int c = 0; c < kPairs; ++c) {
        const __m128i low = _mm_loadl_epi64((const __m128i*)(table + cells.entry[2 * c][s + k]));
        const __m128i high = _mm_loadl_epi64((const __m128i*)(table + cells.entry[2 * c + 1][s + k]));
        const __m128i weight = _mm_set1_epi32(int(cells.weights[c][s + k]));
        sum[k] = _mm_dpbf16_ps(sum[k], (__m128bh)_mm_unpacklo_epi16(low, high), (__m128bh)weight);
      }
    }
    store_quads(sum, rows + s);
  }
}

// As gather_quads, for entries of two features, each one word.
template <int kPairs>
__attribute__((noinline)) void gather_pairs(const std::uint16_t* table, const CellPairs& cells, float* rows) {
  const auto entry = [&](std::size_t c, std::size_t s) { return _mm_loadu_si32(table + cells.entry[c][s]); };
  for (std::size_t s = 0; s < kTile; s += 4) {
    __m128 first = _mm_setzero_ps(), second = _mm_setzero_ps();  // of samples s, s + 1; s + 2, s + 3
#pragma GCC unroll 4
    for (std::size_t c = 0; c < kPairs; ++c) {
      const __m128i weight = _mm_load_si128((const __m128i*)&cells.weights[c][s]);
      const auto two = [&](std::size_t at) {
        return _mm_unpacklo_epi64(_mm_unpacklo_epi16(entry(2 * c, at), entry(2 * c + 1, at)),
                                  _mm_unpacklo_epi16(entry(2 * c, at + 1), entry(2 * c + 1, at + 1)));
      };
      first = _mm_dpbf16_ps(first, (__m128bh)two(s), (__m128bh)_mm_unpacklo_epi32(weight, weight));
      second = _mm_dpbf16_ps(second, (__m128bh)two(s + 2), (__m128bh)_mm_unpackhi_epi32(weight, weight));
    }
    _mm_store_ps(rows + s, _mm_shuffle_ps(first, second, _MM_SHUFFLE(2, 0, 2, 0)));
    _mm_store_ps(rows + kTile + s, _mm_shuffle_ps(first, second, _MM_SHUFFLE(3, 1, 3, 1)));
  }
}

template <int kDims>
inline void encode_tile(const GridLevel& level, const GridConfig& grid, const std::uint16_t* table,
                        const float* const* point, float* rows) {
  CellPairs cells;
  cell_pairs<kDims>(level, grid.features, point, cells);
  constexpr int kPairs = 1 << (kDims - 1);
  if (grid.features == 2) return gather_pairs<kPairs>(table, cells, rows);
  for (int f = 0; f < grid.features; f += 4)
    gather_quads<kPairs>(table + f, cells, rows + std::size_t(f) * kTile);
}

}  // namespace

void round_table(const float* from, std::size_t count, std::uint16_t* to) {
  std::size_t i = 0;
  for (; i + 2 * kWide <= count; i += 2 * kWide)
    _mm512_storeu_si512(
        to + i, bits_of(_mm512_cvtne2ps_pbh(_mm512_loadu_ps(from + i + kWide), _mm512_loadu_ps(from + i))));
  for (; i < count; ++i) to[i] = to_bf16(from[i]);
}

void encode_tile_bf16(const GridLevel& level, const GridConfig& grid, const std::uint16_t* tables,
                      const float* const* point, float* rows) {
  const std::uint16_t* table = tables + level.offset;
  if (grid.dimensions == 3)
    encode_tile<3>(level, grid, table, point, rows);
  else if (grid.dimensions == 2)
    encode_tile<2>(level, grid, table, point, rows);
  else
    encode_tile<1>(level, grid, table, point, rows);
}

LIKENESS_BF16_END

#else

void round_table(const float* from, std::size_t count, std::uint16_t* to) {
  std::transform(from, from + count, to, to_bf16);
}
void encode_tile_bf16(const GridLevel&, const GridConfig&, const std::uint16_t*, const float* const*,
                      float*) {
  LIKENESS_CHECK(false, "no bfloat16 kernels on %s", "this processor");
}

#endif

}  // namespace likeness
