// Dense layers over one tile of samples, for every SIMD target. Included by field_simd.cpp once per target.
//
// Rows of kTile samples; lanes are samples; a block of outputs by two vectors of samples stays in registers
// while weights are broadcast. Gradients of weights need the other order (inputs in lanes), hence the
// transposed inputs.
#if defined(LIKENESS_NETWORK_SIMD_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef LIKENESS_NETWORK_SIMD_INL
#undef LIKENESS_NETWORK_SIMD_INL
#else
#define LIKENESS_NETWORK_SIMD_INL
#endif

#include <cstddef>

#include "core/field/field_kernels.h"
#include "core/field/field_layout.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace likeness {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Df = hn::CappedTag<float, 16>;
using Vf = hn::Vec<Df>;
inline constexpr std::size_t kLanes = hn::MaxLanes(Df());
// As many accumulators as registers allow: 32 registers with 16 lanes, else 16. Six rows would fit there too,
// but are no faster and leave a remainder for every usual width.
inline constexpr int kOutputs = kLanes == 16 ? 8 : 4;

enum class Finish {
  kLinear,  // out = sum
  kRelu,    // out = max(sum, 0)
  kMask,    // out = sum where mask > 0, else 0: the gradient through a ReLU whose output was `mask`
  kAdd      // out += sum
};

// Rows of a tile in two pieces, (first_count, kTile) and (rest_count, kTile), so that neither needs to be
// copied to adjoin the other.
struct InputRows {
  const float* first = nullptr;
  std::size_t first_count = 0;
  const float* rest = nullptr;
  std::size_t rest_count = 0;

  std::size_t count() const { return first_count + rest_count; }
  HWY_INLINE const float* row(std::size_t i) const {
    return i < first_count ? first + i * kTile : rest + (i - first_count) * kTile;
  }
};

// Matrix by strides, so that W and its transpose share the kernel.
struct MatrixView {
  const float* first;
  std::size_t output_stride, input_stride;
};

template <Finish kFinish>
HWY_INLINE void finish_row(Vf sum, const float* mask, float* out) {
  const Df d;
  if constexpr (kFinish == Finish::kRelu) sum = hn::Max(sum, hn::Zero(d));
  if constexpr (kFinish == Finish::kMask)
    sum = hn::IfThenElseZero(hn::Gt(hn::Load(d, mask), hn::Zero(d)), sum);
  if constexpr (kFinish == Finish::kAdd) sum = hn::Add(sum, hn::Load(d, out));
  hn::Store(sum, d, out);
}

template <int kRows, Finish kFinish>
HWY_INLINE void dense_block(const MatrixView& w, const float* bias, const InputRows& in, const float* mask,
                            float* out) {
  const Df d;
  for (std::size_t s = 0; s < kTile; s += 2 * kLanes) {
    Vf low[kRows], high[kRows];
#pragma GCC unroll 8
    for (int o = 0; o < kRows; ++o) low[o] = high[o] = bias ? hn::Set(d, bias[o]) : hn::Zero(d);
    const float* column = w.first;
    const auto add = [&](const float* x, std::size_t count) HWY_ATTR {
      for (std::size_t i = 0; i < count; ++i, x += kTile, column += w.input_stride) {
        const Vf x0 = hn::Load(d, x), x1 = hn::Load(d, x + kLanes);
#pragma GCC unroll 8
        for (int o = 0; o < kRows; ++o) {
          const Vf k = hn::Set(d, column[o * w.output_stride]);
          low[o] = hn::MulAdd(k, x0, low[o]);
          high[o] = hn::MulAdd(k, x1, high[o]);
        }
      }
    };
    add(in.first + s, in.first_count);
    if (in.rest_count > 0) add(in.rest + s, in.rest_count);
#pragma GCC unroll 8
    for (int o = 0; o < kRows; ++o) {
      const std::size_t at = o * kTile + s;
      finish_row<kFinish>(low[o], mask + at, out + at);
      finish_row<kFinish>(high[o], mask + at + kLanes, out + at + kLanes);
    }
  }
}

// out (outputs, kTile) = finish(W in + bias); `bias` and, except for kMask, `mask` may be null.
template <Finish kFinish>
HWY_NOINLINE void dense(MatrixView w, const float* bias, const InputRows& in, std::size_t outputs,
                        const float* mask, float* out) {
  if (!mask) mask = out;
  const auto advance = [&](std::size_t rows) HWY_ATTR {
    w.first += rows * w.output_stride;
    if (bias) bias += rows;
    mask += rows * kTile;
    out += rows * kTile;
    outputs -= rows;
  };
  for (; outputs >= std::size_t(kOutputs); advance(kOutputs)) {
    dense_block<kOutputs, kFinish>(w, bias, in, mask, out);
  }
  if (kOutputs > 4 && outputs >= 4) dense_block<4, kFinish>(w, bias, in, mask, out), advance(4);
  if (outputs >= 2) dense_block<2, kFinish>(w, bias, in, mask, out), advance(2);
  if (outputs >= 1) dense_block<1, kFinish>(w, bias, in, mask, out);
}

// rows (count, kTile) -> out (kTile, stride); columns from count to stride become zero. stride is a multiple
// of 4.
HWY_NOINLINE inline void transpose_tile(const InputRows& rows, std::size_t stride, float* out) {
  const hn::FixedTag<float, 4> d;
  alignas(64) static constexpr float kZeros[kTile] = {};
  for (std::size_t r = 0; r < stride; r += 4) {
    const float* in[4];
    for (std::size_t k = 0; k < 4; ++k) in[k] = r + k < rows.count() ? rows.row(r + k) : kZeros;
    for (std::size_t s = 0; s < kTile; s += 4) {
      const auto a = hn::Load(d, in[0] + s), b = hn::Load(d, in[1] + s);
      const auto c = hn::Load(d, in[2] + s), e = hn::Load(d, in[3] + s);
      const auto ab = hn::InterleaveLower(d, a, b), ce = hn::InterleaveLower(d, c, e);
      const auto AB = hn::InterleaveUpper(d, a, b), CE = hn::InterleaveUpper(d, c, e);
      float* to = out + s * stride + r;
      hn::Store(hn::ConcatLowerLower(d, ce, ab), d, to);
      hn::Store(hn::ConcatUpperUpper(d, ce, ab), d, to + stride);
      hn::Store(hn::ConcatLowerLower(d, CE, AB), d, to + 2 * stride);
      hn::Store(hn::ConcatUpperUpper(d, CE, AB), d, to + 3 * stride);
    }
  }
}

// dW (kRows, kVectors of inputs) += g x^T over the tile.
template <int kRows, int kVectors>
HWY_INLINE void weight_block(const float* g, const float* x, std::size_t stride, float* dw) {
  const Df d;
  Vf sum[kRows][kVectors];
#pragma GCC unroll 8
  for (int o = 0; o < kRows; ++o) {
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) sum[o][v] = hn::Load(d, dw + o * stride + v * kLanes);
  }
  for (std::size_t s = 0; s < kTile; ++s, x += stride) {
    Vf in[kVectors];
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) in[v] = hn::Load(d, x + v * kLanes);
#pragma GCC unroll 8
    for (int o = 0; o < kRows; ++o) {
      const Vf k = hn::Set(d, g[o * kTile + s]);
#pragma GCC unroll 2
      for (int v = 0; v < kVectors; ++v) sum[o][v] = hn::MulAdd(k, in[v], sum[o][v]);
    }
  }
#pragma GCC unroll 8
  for (int o = 0; o < kRows; ++o) {
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) hn::Store(sum[o][v], d, dw + o * stride + v * kLanes);
  }
}

template <int kRows>
HWY_INLINE void weight_rows(const float* g, const float* x, std::size_t stride, float* dw) {
  std::size_t i = 0;
  for (; i + 2 * kLanes <= stride; i += 2 * kLanes) weight_block<kRows, 2>(g, x + i, stride, dw + i);
  for (; i < stride; i += kLanes) weight_block<kRows, 1>(g, x + i, stride, dw + i);
}

// Adds one tile's gradients of a layer: g (outputs, kTile), x (inputs, kTile). `turned`: scratch (kTile,
// stride).
HWY_NOINLINE inline void layer_gradients(const float* g, const InputRows& x, const DenseLayer& layer,
                                         const PartialLayer& to, float* partial, float* turned) {
  transpose_tile(x, to.stride, turned);
  float* dw = partial + to.weights;
  std::size_t o = 0, outputs = std::size_t(layer.outputs);
  for (; o + kOutputs <= outputs; o += kOutputs) {
    weight_rows<kOutputs>(g + o * kTile, turned, to.stride, dw + o * to.stride);
  }
  if (o + 4 <= outputs) weight_rows<4>(g + o * kTile, turned, to.stride, dw + o * to.stride), o += 4;
  if (o + 2 <= outputs) weight_rows<2>(g + o * kTile, turned, to.stride, dw + o * to.stride), o += 2;
  if (o < outputs) weight_rows<1>(g + o * kTile, turned, to.stride, dw + o * to.stride);
  const Df d;
  for (o = 0; o < outputs; ++o) {
    float* bias = partial + to.biases + o * kPartialLanes;
    Vf sum = hn::Load(d, bias);
    for (std::size_t s = 0; s < kTile; s += kLanes) sum = hn::Add(sum, hn::Load(d, g + o * kTile + s));
    hn::Store(sum, d, bias);
  }
}

// hidden[l] (width, kTile) receives the ReLU outputs, `out` the first `outputs` of the linear output layer's.
HWY_NOINLINE inline void network_forward(const float* parameters, const std::vector<DenseLayer>& layers,
                                         InputRows in, float* const* hidden, std::size_t outputs,
                                         float* out) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const DenseLayer& layer = layers[l];
    const MatrixView w{parameters + layer.weights, std::size_t(layer.inputs), 1};
    const float* bias = parameters + layer.biases;
    if (l + 1 < layers.size()) {
      dense<Finish::kRelu>(w, bias, in, layer.outputs, nullptr, hidden[l]);
      in = {hidden[l], std::size_t(layer.outputs)};
    } else {
      dense<Finish::kLinear>(w, bias, in, outputs, nullptr, out);
    }
  }
}

// From g, the gradient of the output, adds all layers' gradients; returns the gradient of the first layer's
// sums. `below`: two scratch tiles of hidden width.
HWY_NOINLINE inline const float* network_backward(const float* parameters,
                                                  const std::vector<DenseLayer>& layers, const InputRows& in,
                                                  float* const* hidden, const float* g, float* const* below,
                                                  const std::vector<PartialLayer>& to, float* partial,
                                                  float* turned) {
  for (std::size_t l = layers.size(); l-- > 0;) {
    const DenseLayer& layer = layers[l];
    layer_gradients(g, l == 0 ? in : InputRows{hidden[l - 1], std::size_t(layer.inputs)}, layer, to[l],
                    partial, turned);
    if (l == 0) break;
    const MatrixView transposed{parameters + layer.weights, 1, std::size_t(layer.inputs)};
    float* next = below[l & 1];
    dense<Finish::kMask>(transposed, nullptr, {g, std::size_t(layer.outputs)}, layer.inputs, hidden[l - 1],
                         next);
    g = next;
  }
  return g;
}

// Rows [first, first + count) of the gradient of a network's input, from network_backward's result.
template <Finish kFinish>
inline void input_gradient(const float* parameters, const DenseLayer& layer, const float* g,
                           std::size_t first, std::size_t count, float* out) {
  const MatrixView transposed{parameters + layer.weights + first, 1, std::size_t(layer.inputs)};
  dense<kFinish>(transposed, nullptr, {g, std::size_t(layer.outputs)}, count, nullptr, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace likeness
HWY_AFTER_NAMESPACE();

#endif
