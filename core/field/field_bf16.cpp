// Look-ups and dense layers in bfloat16 by intrinsics: see field_bf16.h.
#include "core/field/field_bf16.h"

#include <algorithm>
#include <bit>

#include "core/base/check.h"
#include "core/field/field_kernels.h"

#if defined(__x86_64__) && defined(__GNUC__)
#define LIKENESS_BF16_KERNELS 1
#include <immintrin.h>
#endif

namespace likeness {

std::uint16_t to_bf16(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  if ((bits & 0x7fffffffu) > 0x7f800000u) return std::uint16_t(bits >> 16 | 0x40u);  // not a number
  return std::uint16_t((bits + 0x7fffu + (bits >> 16 & 1u)) >> 16);
}

float from_bf16(std::uint16_t value) { return std::bit_cast<float>(std::uint32_t(value) << 16); }

PackedNetwork pack_network(const std::vector<DenseLayer>& layers, const float* parameters) {
  PackedNetwork network;
  for (const DenseLayer& layer : layers) {
    PackedLayer packed{layer.inputs, layer.outputs, {}, {}};
    packed.biases.assign(parameters + layer.biases, parameters + layer.biases + layer.outputs);
    const auto at = [&](int output, int input) {
      if (output >= layer.outputs || input >= layer.inputs) return std::uint32_t{0};
      return std::uint32_t(to_bf16(
          parameters[layer.weights + std::size_t(output) * std::size_t(layer.inputs) + std::size_t(input)]));
    };
    for (int block = 0; block < layer.outputs; block += 8)
      for (int input = 0; input < layer.inputs; input += 2)
        for (int o = block; o < block + 8; ++o)
          packed.weights.push_back(at(o, input) | at(o, input + 1) << 16);
    network.push_back(std::move(packed));
  }
  return network;
}

bool grid_has_bf16(const GridConfig& grid) {
  return grid.features == 2 || grid.features == 4 || grid.features == 8;
}

#ifdef LIKENESS_BF16_KERNELS

bool cpu_has_bf16() {
  static const bool has = __builtin_cpu_supports("avx512bf16") && __builtin_cpu_supports("avx512bw") &&
                          __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
                          __builtin_cpu_supports("fma");
  return has;
}

// Only what stands between these lines is compiled for such processors: nothing of the standard library is.
#ifdef __clang__
#pragma clang attribute push( \
    __attribute__((target("avx2,fma,avx512f,avx512bw,avx512vl,avx512dq,avx512bf16"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma,avx512f,avx512bw,avx512vl,avx512dq,avx512bf16")
#endif

namespace {

constexpr std::size_t kWide = 16;  // lanes

inline __m512i bits_of(__m512bh v) { return (__m512i)v; }
inline __m512bh pairs_of(__m512i v) { return (__m512bh)v; }

// Words (first | second << 16) of two vectors, rounded.
inline __m512i paired(__m512 first, __m512 second) {
  const __m512i apart = bits_of(_mm512_cvtne2ps_pbh(second, first));
  const __m512i order = _mm512_set_epi16(31, 15, 30, 14, 29, 13, 28, 12, 27, 11, 26, 10, 25, 9, 24, 8, 23, 7,
                                         22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0);
  return _mm512_permutexvar_epi16(order, apart);
}

// -- Look-ups

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

// -- Dense layers

// kRows outputs of the kTile samples from pairs of inputs. Hidden layers end in ReLU and words of two
// outputs, the last one in rows.
template <int kRows, bool kHidden>
inline void layer_rows(const std::uint32_t* weights, const float* biases, const std::uint32_t* in,
                       std::size_t pairs, std::uint32_t* words, float* rows) {
  for (std::size_t s = 0; s < kTile; s += 2 * kWide) {
    __m512 low[kRows], high[kRows];
#pragma GCC unroll 8
    for (int o = 0; o < kRows; ++o) low[o] = high[o] = _mm512_set1_ps(biases[o]);
    const std::uint32_t *x = in + s, *w = weights;
    for (std::size_t i = 0; i < pairs; ++i, x += kTile, w += 8) {
      const __m512bh x0 = pairs_of(_mm512_load_si512(x)), x1 = pairs_of(_mm512_load_si512(x + kWide));
#pragma GCC unroll 8
      for (int o = 0; o < kRows; ++o) {
        const __m512bh k = pairs_of(_mm512_set1_epi32(int(w[o])));
        low[o] = _mm512_dpbf16_ps(low[o], x0, k);
        high[o] = _mm512_dpbf16_ps(high[o], x1, k);
      }
    }
    if constexpr (kHidden) {
      const __m512 zero = _mm512_setzero_ps();
#pragma GCC unroll 4
      for (int o = 0; o < kRows; o += 2) {
        std::uint32_t* to = words + std::size_t(o / 2) * kTile + s;
        const __m512 low1 = o + 1 < kRows ? low[(o + 1) % kRows] : zero;
        const __m512 high1 = o + 1 < kRows ? high[(o + 1) % kRows] : zero;
        _mm512_store_si512(to, paired(_mm512_max_ps(low[o], zero), _mm512_max_ps(low1, zero)));
        _mm512_store_si512(to + kWide, paired(_mm512_max_ps(high[o], zero), _mm512_max_ps(high1, zero)));
      }
    } else {
#pragma GCC unroll 8
      for (int o = 0; o < kRows; ++o) {
        _mm512_store_ps(rows + std::size_t(o) * kTile + s, low[o]);
        _mm512_store_ps(rows + std::size_t(o) * kTile + s + kWide, high[o]);
      }
    }
  }
}

template <bool kHidden>
__attribute__((noinline)) void layer_tile(const PackedLayer& layer, const std::uint32_t* in,
                                          std::size_t outputs, std::uint32_t* words, float* rows) {
  const std::size_t pairs = (std::size_t(layer.inputs) + 1) / 2;
  const std::uint32_t* weights = layer.weights.data();
  const float* biases = layer.biases.data();
  const auto advance = [&](std::size_t count) {
    biases += count, outputs -= count;
    if constexpr (kHidden)
      words += count / 2 * kTile;
    else
      rows += count * kTile;
  };
  for (; outputs >= 8; advance(8), weights += 8 * pairs)
    layer_rows<8, kHidden>(weights, biases, in, pairs, words, rows);
  if (outputs >= 4) layer_rows<4, kHidden>(weights, biases, in, pairs, words, rows), advance(4), weights += 4;
  if (outputs >= 2) layer_rows<2, kHidden>(weights, biases, in, pairs, words, rows), advance(2), weights += 2;
  if (outputs >= 1) layer_rows<1, kHidden>(weights, biases, in, pairs, words, rows);
}

__attribute__((noinline)) void pair_rows(const float* rows, std::size_t count, std::uint32_t* words) {
  for (std::size_t r = 0; r < count; r += 2, rows += 2 * kTile, words += kTile)
    for (std::size_t s = 0; s < kTile; s += kWide) {
      const __m512 second = r + 1 < count ? _mm512_load_ps(rows + kTile + s) : _mm512_setzero_ps();
      _mm512_store_si512(words + s, paired(_mm512_load_ps(rows + s), second));
    }
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

void network_bf16(const PackedNetwork& network, const float* in, const PairScratch& scratch,
                  std::size_t outputs, float* out) {
  pair_rows(in, std::size_t(network.front().inputs), scratch.in);
  const std::uint32_t* words = scratch.in;
  for (std::size_t l = 0; l + 1 < network.size(); ++l) {
    layer_tile<true>(network[l], words, std::size_t(network[l].outputs), scratch.hidden[l & 1], nullptr);
    words = scratch.hidden[l & 1];
  }
  layer_tile<false>(network.back(), words, outputs, nullptr, out);
}

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#else

bool cpu_has_bf16() { return false; }
void round_table(const float* from, std::size_t count, std::uint16_t* to) {
  std::transform(from, from + count, to, to_bf16);
}
void encode_tile_bf16(const GridLevel&, const GridConfig&, const std::uint16_t*, const float* const*,
                      float*) {
  LIKENESS_CHECK(false, "no bfloat16 kernels on %s", "this processor");
}
void network_bf16(const PackedNetwork&, const float*, const PairScratch&, std::size_t, float*) {
  LIKENESS_CHECK(false, "no bfloat16 kernels on %s", "this processor");
}

#endif

}  // namespace likeness
