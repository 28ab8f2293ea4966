// Dense layers in bfloat16 with intrinsics, forward and backward: see field_bf16.h.
//
// Forward as in network_simd-inl.h: lanes are samples, weights are broadcast, and a word holds two inputs of
// a sample. The gradients of inputs are the same with transposed weights. For those of weights, lanes are
// inputs, and a word holds two neighbouring samples of one input.
#include "core/base/check.h"
#include "core/field/bf16_intrinsics.h"
#include "core/field/field_bf16.h"
#include "core/field/field_kernels.h"

namespace likeness {

#ifdef LIKENESS_BF16_KERNELS

LIKENESS_BF16_BEGIN

using namespace bf16;

namespace {

constexpr std::size_t kTilePairs = kTile / 2;  // of neighbouring samples
static_assert(kPartialLanes == kWide);

// What is done with a layer's sums.
enum class Finish {
  kRows,   // rows of floats
  kRelu,   // words of two outputs of max(sum, 0)
  kSlopes  // words of the sums where `mask`, the words that a ReLU gave, is not zero, and zero elsewhere
};

// Gradients of a layer's sums, for the layer below, for its weights and for its biases.
struct SlopeRows {
  std::uint32_t* pairs = nullptr;    // (pairs of rows, kTile) words
  std::uint32_t* samples = nullptr;  // (rows, kTilePairs) words
  float* biases = nullptr;           // (rows, kPartialLanes), added to
};

// Where a layer's sums go, by Finish.
struct LayerResult {
  float* rows = nullptr;
  std::uint32_t* words = nullptr;
  const std::uint32_t* mask = nullptr;
  SlopeRows slopes;
};

// Two rows' gradients of samples [s, s + 32): low and high halves of each.
template <bool kTwo>
inline void store_slopes(__m512 low, __m512 high, __m512 low1, __m512 high1, std::size_t row, std::size_t s,
                         const SlopeRows& to) {
  std::uint32_t* pairs = to.pairs + row / 2 * kTile + s;
  _mm512_store_si512(pairs, paired(low, low1));
  _mm512_store_si512(pairs + kWide, paired(high, high1));
  std::uint32_t* samples = to.samples + row * kTilePairs + s / 2;
  float* biases = to.biases + row * kPartialLanes;
  _mm512_store_si512(samples, bits_of(_mm512_cvtne2ps_pbh(high, low)));
  _mm512_store_ps(biases, _mm512_add_ps(_mm512_load_ps(biases), _mm512_add_ps(low, high)));
  if constexpr (kTwo) {
    _mm512_store_si512(samples + kTilePairs, bits_of(_mm512_cvtne2ps_pbh(high1, low1)));
    _mm512_store_ps(biases + kPartialLanes,
                    _mm512_add_ps(_mm512_load_ps(biases + kPartialLanes), _mm512_add_ps(low1, high1)));
  }
}

// The sum where the word's lower or upper half is not zero.
inline __m512 masked(__m512 sum, const std::uint32_t* mask, int half) {
  return _mm512_maskz_mov_ps(_mm512_test_epi32_mask(_mm512_load_si512(mask), _mm512_set1_epi32(half)), sum);
}

// Outputs [row, row + kRows) of samples [s, s + 32).
template <int kRows, Finish kFinish>
inline void finish_rows(const __m512 (&low)[kRows], const __m512 (&high)[kRows], std::size_t row,
                        std::size_t s, const LayerResult& to) {
  constexpr bool kTwo = kRows > 1;
  constexpr int kLower = 0xffff, kUpper = int(0xffff0000u);
  const __m512 zero = _mm512_setzero_ps();
#pragma GCC unroll 8
  for (int o = 0; o < kRows; o += kFinish == Finish::kRows ? 1 : 2) {
    if constexpr (kFinish == Finish::kRows) {
      float* rows = to.rows + (row + std::size_t(o)) * kTile + s;
      _mm512_store_ps(rows, low[o]);
      _mm512_store_ps(rows + kWide, high[o]);
      continue;
    }
    const std::size_t place = (row + std::size_t(o)) / 2 * kTile + s;
    const __m512 low1 = kTwo ? low[(o + 1) % kRows] : zero, high1 = kTwo ? high[(o + 1) % kRows] : zero;
    if constexpr (kFinish == Finish::kRelu) {
      _mm512_store_si512(to.words + place, paired(_mm512_max_ps(low[o], zero), _mm512_max_ps(low1, zero)));
      _mm512_store_si512(to.words + place + kWide,
                         paired(_mm512_max_ps(high[o], zero), _mm512_max_ps(high1, zero)));
    } else if constexpr (kFinish == Finish::kSlopes) {
      const std::uint32_t *mask = to.mask + place, *next = mask + kWide;
      store_slopes<kTwo>(masked(low[o], mask, kLower), masked(high[o], next, kLower),
                         masked(low1, mask, kUpper), masked(high1, next, kUpper), row + std::size_t(o), s,
                         to.slopes);
    }
  }
}

// kRows outputs, from `row` on, of the kTile samples from pairs of inputs.
template <int kRows, Finish kFinish>
inline void layer_rows(const std::uint32_t* weights, const float* biases, const std::uint32_t* in,
                       std::size_t pairs, std::size_t row, const LayerResult& to) {
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
    finish_rows<kRows, kFinish>(low, high, row, s, to);
  }
}

// For a layer without inputs: there is nothing to read, but pointers advance.
constexpr std::uint32_t kNoWeights[8] = {};

template <Finish kFinish>
__attribute__((noinline)) void layer_tile(const PackedLayer& layer, const std::uint32_t* in,
                                          std::size_t outputs, const LayerResult& to) {
  const std::size_t pairs = (std::size_t(layer.inputs) + 1) / 2;
  const std::uint32_t* weights = pairs > 0 ? layer.weights.data() : kNoWeights;
  const float* biases = layer.biases.data();
  std::size_t o = 0;
  for (; o + 8 <= outputs; o += 8, weights += 8 * pairs)
    layer_rows<8, kFinish>(weights, biases + o, in, pairs, o, to);
  if (o + 4 <= outputs) layer_rows<4, kFinish>(weights, biases + o, in, pairs, o, to), o += 4, weights += 4;
  if (o + 2 <= outputs) layer_rows<2, kFinish>(weights, biases + o, in, pairs, o, to), o += 2, weights += 2;
  if (o < outputs) layer_rows<1, kFinish>(weights, biases + o, in, pairs, o, to);
}

__attribute__((noinline)) void pair_rows(const float* rows, std::size_t count, std::uint32_t* words) {
  for (std::size_t r = 0; r < count; r += 2, rows += 2 * kTile, words += kTile)
    for (std::size_t s = 0; s < kTile; s += kWide) {
      const __m512 second = r + 1 < count ? _mm512_load_ps(rows + kTile + s) : _mm512_setzero_ps();
      _mm512_store_si512(words + s, paired(_mm512_load_ps(rows + s), second));
    }
}

// -- Back

// Gradients of the output layer's sums in the layout of the layers below.
__attribute__((noinline)) void slopes_of(const float* rows, std::size_t count, const SlopeRows& to) {
  const __m512 zero = _mm512_setzero_ps();
  for (std::size_t r = 0; r < count; r += 2)
    for (std::size_t s = 0; s < kTile; s += 2 * kWide) {
      const float* first = rows + r * kTile + s;
      const float* second = first + kTile;
      const __m512 low = _mm512_load_ps(first), high = _mm512_load_ps(first + kWide);
      if (r + 1 < count)
        store_slopes<true>(low, high, _mm512_load_ps(second), _mm512_load_ps(second + kWide), r, s, to);
      else
        store_slopes<false>(low, high, zero, zero, r, s, to);
    }
}

// Columns to rows of an 8 x 8 matrix of pairs of words.
inline void transpose_pairs(__m512i (&v)[8]) {
  __m512i even[4], odd[4];
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    even[k] = _mm512_unpacklo_epi64(v[2 * k], v[2 * k + 1]);
    odd[k] = _mm512_unpackhi_epi64(v[2 * k], v[2 * k + 1]);
  }
#pragma GCC unroll 2
  for (int side = 0; side < 2; ++side) {
    const __m512i* t = side ? odd : even;
    const __m512i a = _mm512_shuffle_i64x2(t[0], t[1], 0x44), b = _mm512_shuffle_i64x2(t[0], t[1], 0xee);
    const __m512i c = _mm512_shuffle_i64x2(t[2], t[3], 0x44), d = _mm512_shuffle_i64x2(t[2], t[3], 0xee);
    v[side] = _mm512_shuffle_i64x2(a, c, 0x88), v[2 + side] = _mm512_shuffle_i64x2(a, c, 0xdd);
    v[4 + side] = _mm512_shuffle_i64x2(b, d, 0x88), v[6 + side] = _mm512_shuffle_i64x2(b, d, 0xdd);
  }
}

// (pairs of inputs, kTile) words -> (kTilePairs, stride): a word holds two samples of one input.
__attribute__((noinline)) void turn_words(const std::uint32_t* words, std::size_t pairs, std::size_t stride,
                                          std::uint32_t* turned) {
  // Of two neighbouring samples' words (a, b), (a', b'): (a, a'), (b, b').
  const __m512i order =
      _mm512_broadcast_i32x4(_mm_setr_epi8(0, 1, 4, 5, 2, 3, 6, 7, 8, 9, 12, 13, 10, 11, 14, 15));
  for (std::size_t i = 0; i < stride; i += kWide)
    for (std::size_t s = 0; s < kTile; s += kWide) {
      __m512i v[8];
#pragma GCC unroll 8
      for (std::size_t k = 0; k < 8; ++k)
        v[k] = i / 2 + k < pairs
                   ? _mm512_shuffle_epi8(_mm512_load_si512(words + (i / 2 + k) * kTile + s), order)
                   : _mm512_setzero_si512();
      transpose_pairs(v);
#pragma GCC unroll 8
      for (std::size_t k = 0; k < 8; ++k) _mm512_store_si512(turned + (s / 2 + k) * stride + i, v[k]);
    }
}

// dW (kRows, kVectors of inputs) += g x^T over the tile.
template <int kRows, int kVectors>
inline void weight_block(const std::uint32_t* g, const std::uint32_t* x, std::size_t stride, float* dw) {
  __m512 sum[kRows][kVectors];
#pragma GCC unroll 8
  for (int o = 0; o < kRows; ++o) {
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) sum[o][v] = _mm512_load_ps(dw + std::size_t(o) * stride + 16 * v);
  }
  for (std::size_t p = 0; p < kTilePairs; ++p, x += stride) {
    __m512bh in[kVectors];
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) in[v] = pairs_of(_mm512_load_si512(x + 16 * v));
#pragma GCC unroll 8
    for (int o = 0; o < kRows; ++o) {
      const __m512bh k = pairs_of(_mm512_set1_epi32(int(g[std::size_t(o) * kTilePairs + p])));
#pragma GCC unroll 2
      for (int v = 0; v < kVectors; ++v) sum[o][v] = _mm512_dpbf16_ps(sum[o][v], in[v], k);
    }
  }
#pragma GCC unroll 8
  for (int o = 0; o < kRows; ++o) {
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) _mm512_store_ps(dw + std::size_t(o) * stride + 16 * v, sum[o][v]);
  }
}

template <int kRows>
inline void weight_rows(const std::uint32_t* g, const std::uint32_t* x, std::size_t stride, float* dw) {
  std::size_t i = 0;
  for (; i + 2 * kWide <= stride; i += 2 * kWide) weight_block<kRows, 2>(g, x + i, stride, dw + i);
  if (i < stride) weight_block<kRows, 1>(g, x + i, stride, dw + i);
}

__attribute__((noinline)) void weight_gradients(const std::uint32_t* g, const std::uint32_t* x,
                                                std::size_t stride, std::size_t outputs, float* dw) {
  std::size_t o = 0;
  for (; o + 8 <= outputs; o += 8) weight_rows<8>(g + o * kTilePairs, x, stride, dw + o * stride);
  if (o + 4 <= outputs) weight_rows<4>(g + o * kTilePairs, x, stride, dw + o * stride), o += 4;
  if (o + 2 <= outputs) weight_rows<2>(g + o * kTilePairs, x, stride, dw + o * stride), o += 2;
  if (o < outputs) weight_rows<1>(g + o * kTilePairs, x, stride, dw + o * stride);
}

}  // namespace

void network_bf16(const PackedNetwork& network, const float* in, const PairRows& words, std::size_t outputs,
                  float* out) {
  pair_rows(in, std::size_t(network.front().inputs), words.in);
  const std::uint32_t* below = words.in;
  LayerResult to;
  for (std::size_t l = 0; l + 1 < network.size(); ++l) {
    to.words = words.hidden[l & 1];
    layer_tile<Finish::kRelu>(network[l], below, std::size_t(network[l].outputs), to);
    below = to.words;
  }
  to.rows = out;
  layer_tile<Finish::kRows>(network.back(), below, outputs, to);
}

const std::uint32_t* network_backward_bf16(const PackedNetwork& transposed, const PairRows& kept,
                                           const float* g, const std::vector<PartialLayer>& to,
                                           float* partial, const SlopeScratch& scratch) {
  const std::size_t last = transposed.size() - 1;
  SlopeRows slopes{scratch.pairs[last & 1], scratch.samples, partial + to[last].biases};
  slopes_of(g, std::size_t(transposed[last].inputs), slopes);
  for (std::size_t l = last;; --l) {
    const PackedLayer& layer = transposed[l];
    const std::size_t inputs = std::size_t(layer.outputs);
    const std::uint32_t* x = l == 0 ? kept.in : kept.hidden[(l - 1) & 1];
    turn_words(x, (inputs + 1) / 2, to[l].stride, scratch.turned);
    weight_gradients(slopes.samples, scratch.turned, to[l].stride, std::size_t(layer.inputs),
                     partial + to[l].weights);
    if (l == 0) return slopes.pairs;
    LayerResult below;
    below.mask = x;
    below.slopes = {scratch.pairs[(l - 1) & 1], scratch.samples, partial + to[l - 1].biases};
    layer_tile<Finish::kSlopes>(layer, slopes.pairs, inputs, below);
    slopes = below.slopes;
  }
}

void input_gradient_bf16(const PackedLayer& transposed, const std::uint32_t* g, float* rows) {
  LayerResult to;
  to.rows = rows;
  layer_tile<Finish::kRows>(transposed, g, std::size_t(transposed.outputs), to);
}

LIKENESS_BF16_END

#else

void network_bf16(const PackedNetwork&, const float*, const PairRows&, std::size_t, float*) {
  LIKENESS_CHECK(false, "no bfloat16 kernels on %s", "this processor");
}
const std::uint32_t* network_backward_bf16(const PackedNetwork&, const PairRows&, const float*,
                                           const std::vector<PartialLayer>&, float*, const SlopeScratch&) {
  LIKENESS_CHECK(false, "no bfloat16 kernels on %s", "this processor");
  return nullptr;
}
void input_gradient_bf16(const PackedLayer&, const std::uint32_t*, float*) {
  LIKENESS_CHECK(false, "no bfloat16 kernels on %s", "this processor");
}

#endif

}  // namespace likeness
