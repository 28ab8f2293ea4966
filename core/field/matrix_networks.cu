// The field's networks on matrix units: a warp takes 16 samples through all layers, their hidden values in
// its registers. network_math.h does the same in plain loops, for networks not covered here: wider ones, more
// layers, devices without such units.
//
// With NetworkPrecision::split every factor is the sum of two bfloat16 values, and a product is three of
// theirs: about single precision.
#include "core/field/cuda_launchers.h"
#include "core/field/device_math.h"
#include "core/field/network_math.h"

#if !defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 800
#include "core/field/fragments.h"
#define LIKENESS_MATRIX_UNITS 1
#endif

namespace likeness::cuda {
namespace {

constexpr int kWarps = 8, kThreads = 32 * kWarps;
constexpr int kRows = 16 * kWarps;  // samples of a tile
constexpr int kMaxInputs = 96;      // padded
constexpr int kOutputs = 16;        // padded

extern __shared__ __align__(128) unsigned char block_memory[];

// Layout of shared memory, bytes; of values kept in two parts, the second follows the first.
struct MatrixMemory {
  int first, middle, last, biases, inputs, hidden, slopes, end;
};

template <int kWidth, int kHidden, bool kSplit>
__host__ __device__ MatrixMemory matrix_memory(int inputs, bool backward) {
  constexpr int kCopies = kSplit ? 2 : 1, kStride = kWidth + 8;
  MatrixMemory m{};
  int at = 0;
  const auto take = [&](int values) {
    const int here = at;
    at += (values * kCopies * 2 + 127) / 128 * 128;
    return here;
  };
  m.first = take(kWidth * (inputs + 8));
  m.middle = take((kHidden - 1) * kWidth * kStride);
  m.last = take(kOutputs * kStride);
  m.biases = at;
  at += (kHidden * kWidth + kOutputs) * 4;
  m.inputs = take(kRows * (inputs + 8));
  if (backward) m.hidden = take(kRows * kStride), m.slopes = take(kRows * kStride);
  m.end = at;
  return m;
}

// Parameters of a network in the order of the work space: each layer's weights, then its biases.
__host__ __device__ inline std::uint32_t layer_parameters(const DeviceLayer& layer) {
  return std::uint32_t(layer.outputs) * std::uint32_t(layer.inputs + 1);
}

#ifdef LIKENESS_MATRIX_UNITS

// Values of one rounded part, or of two that add up to them.
template <bool kSplit>
struct Pieces {
  Piece part[kSplit ? 2 : 1];
};

template <bool kSplit>
__device__ inline void set_pair(Pieces<kSplit>& pieces, int k, float first, float second) {
  pieces.part[0].part[k] = rounded_pair(first, second);
  if (kSplit) pieces.part[kSplit].part[k] = rounded_rest(first, second);
}

template <bool kSplit>
__device__ inline Pieces<kSplit> pieces_of(const Sums& left, const Sums& right) {
  Pieces<kSplit> pieces;
#pragma unroll
  for (int k = 0; k < 4; ++k) {
    const Sums& sums = k < 2 ? left : right;
    set_pair(pieces, k, sums.value[k % 2 * 2], sums.value[k % 2 * 2 + 1]);
  }
  return pieces;
}

// A block of shared memory that holds values in one or two parts.
template <bool kSplit>
struct Values {
  Bf16* at;
  int stride, part;  // values from one row to the next, and from the first part to the second

  __device__ Values(int offset, int row_stride, int rows)
      : at(reinterpret_cast<Bf16*>(block_memory + offset)), stride(row_stride), part(rows * row_stride) {}
  template <class How>
  __device__ Pieces<kSplit> load(int row, int column) const {
    Pieces<kSplit> pieces;
    pieces.part[0] = How::load(at + row * stride + column, stride);
    if (kSplit) pieces.part[kSplit] = How::load(at + part + row * stride + column, stride);
    return pieces;
  }
  __device__ void store(const Pieces<kSplit>& pieces, int row, int column) const {
    store_piece(pieces.part[0], at + row * stride + column, stride);
    if (kSplit) store_piece(pieces.part[kSplit], at + part + row * stride + column, stride);
  }
  __device__ void set(int row, int column, float value) const {
    const Bf16 whole = __float2bfloat16_rn(value);
    at[row * stride + column] = whole;
    if (kSplit) at[part + row * stride + column] = __float2bfloat16_rn(value - __bfloat162float(whole));
  }
};

// sums += left * right's parts 2 half and 2 half + 1
template <bool kSplit>
__device__ inline void multiply(Sums& sums, const Pieces<kSplit>& left, const Pieces<kSplit>& right,
                                int half) {
  multiply(sums, left.part[0], right.part[0].part[2 * half], right.part[0].part[2 * half + 1]);
  if (!kSplit) return;
  multiply(sums, left.part[0], right.part[kSplit].part[2 * half], right.part[kSplit].part[2 * half + 1]);
  multiply(sums, left.part[kSplit], right.part[0].part[2 * half], right.part[0].part[2 * half + 1]);
}

template <int kWidth, int kHidden, bool kSplit>
struct MatrixNetwork {
  static constexpr int kPieces = kWidth / 16, kStride = kWidth + 8;
  using Hidden = Pieces<kSplit>[kPieces];

  const NetworkArgs& a;
  int inputs, row;  // padded; the warp's first in the tile
  MatrixMemory memory;
  float* biases;

  __device__ MatrixNetwork(const NetworkArgs& args, bool backward)
      : a(args),
        inputs(padded(args.network.layer[0].inputs)),
        row(int(threadIdx.x) / 32 * 16),
        memory(matrix_memory<kWidth, kHidden, kSplit>(inputs, backward)),
        biases(reinterpret_cast<float*>(block_memory + memory.biases)) {}

  __device__ Values<kSplit> weights(int l) const {
    if (l == 0) return {memory.first, inputs + 8, kWidth};
    if (l < kHidden) return {memory.middle, kStride, kWidth};
    return {memory.last, kStride, kOutputs};
  }
  __device__ Values<kSplit> tile_inputs() const { return {memory.inputs, inputs + 8, kRows}; }
  __device__ Values<kSplit> tile_hidden() const { return {memory.hidden, kStride, kRows}; }
  __device__ Values<kSplit> tile_slopes() const { return {memory.slopes, kStride, kRows}; }

  __device__ void load_weights() const {
    for (int l = 0; l <= kHidden; ++l) {
      const DeviceLayer& layer = a.network.layer[l];
      const Values<kSplit> to = weights(l);
      const int columns = l == 0 ? inputs : kWidth, rows = l < kHidden ? kWidth : kOutputs;
      for (int i = int(threadIdx.x) % 32; i < columns; i += 32)
        for (int o = int(threadIdx.x) / 32; o < rows; o += kWarps) {
          const bool there = o < layer.outputs && i < layer.inputs;
          to.set(o, i, there ? a.parameters[layer.weights + std::uint32_t(o * layer.inputs + i)] : 0.0f);
        }
      for (int o = int(threadIdx.x); o < rows; o += kThreads)
        biases[l * kWidth + o] = o < layer.outputs ? a.parameters[layer.biases + std::uint32_t(o)] : 0.0f;
    }
    __syncthreads();
  }

  // Eight components of sample n's input from k on; zeros after the last one.
  __device__ void load_eight(int k, std::uint32_t n, float (&value)[8]) const {
    if (k + 8 <= a.column_count) {
      const float* at = a.columns + std::size_t(k) * a.capacity + n;
#pragma unroll
      for (int e = 0; e < 8; ++e) value[e] = at[std::size_t(e) * a.capacity];
      return;
    }
#pragma unroll
    for (int e = 0; e < 8; ++e)
      value[e] = k + e < a.network.layer[0].inputs ? network_input(a, k + e, n) : 0.0f;
  }

  // The warp's samples, from `first` of the tile on; none beyond the last one. A thread loads 8 components at
  // a time, twice, so that the loads overlap.
  __device__ void load_inputs(std::uint32_t first, std::uint32_t count) const {
    const int lane = lane_id(), own = row + lane % 16;
    const bool there = first + std::uint32_t(own) < count;
    const std::uint32_t n = there ? first + std::uint32_t(own) : count - 1;
    const Values<kSplit> to = tile_inputs();
    for (int begin = lane / 16 * 8; begin < inputs; begin += 32) {
      float value[2][8];
#pragma unroll
      for (int part = 0; part < 2; ++part) load_eight(begin + 16 * part, n, value[part]);
#pragma unroll
      for (int part = 0; part < 2; ++part) {
        if (begin + 16 * part >= inputs) break;
        float(&v)[8] = value[part];
#pragma unroll
        for (float& component : v) component = there ? component : 0.0f;
        Bf16* at = to.at + own * to.stride + begin + 16 * part;
        *reinterpret_cast<uint4*>(at) = {rounded_pair(v[0], v[1]), rounded_pair(v[2], v[3]),
                                         rounded_pair(v[4], v[5]), rounded_pair(v[6], v[7])};
        if (kSplit)
          *reinterpret_cast<uint4*>(at + to.part) = {rounded_rest(v[0], v[1]), rounded_rest(v[2], v[3]),
                                                     rounded_rest(v[4], v[5]), rounded_rest(v[6], v[7])};
      }
    }
    __syncwarp();
  }

  __device__ Sums from_bias(int l, int column) const {
    const float* b = biases + l * kWidth + column + lane_id() % 4 * 2;
    return {{b[0], b[1], b[0], b[1]}};
  }

  __device__ static void cut_off(Sums (&sums)[kPieces][2], Hidden& out) {
#pragma unroll
    for (int p = 0; p < kPieces; ++p) {
#pragma unroll
      for (int h = 0; h < 2; ++h)
        for (float& value : sums[p][h].value) value = value > 0 ? value : 0.0f;
      out[p] = pieces_of<kSplit>(sums[p][0], sums[p][1]);
    }
  }

  // Values of hidden layer l from those of the layer below, a piece at a time.
  template <class Left>
  __device__ void hidden(int l, int pieces, const Left& left, Hidden& out) const {
    Sums sums[kPieces][2];
#pragma unroll
    for (int p = 0; p < kPieces; ++p)
      for (int h = 0; h < 2; ++h) sums[p][h] = from_bias(l, 16 * p + 8 * h);
    const Values<kSplit> w = weights(l);
    for (int k = 0; k < pieces; ++k) {
      const Pieces<kSplit> own = left(k);
#pragma unroll
      for (int p = 0; p < kPieces; ++p) {
        const Pieces<kSplit> right = w.template load<ToOutputs>(16 * p, 16 * k);
        multiply(sums[p][0], own, right, 0);
        multiply(sums[p][1], own, right, 1);
      }
    }
    cut_off(sums, out);
  }

  __device__ void first_hidden(Hidden& out) const {
    const Values<kSplit> in = tile_inputs();
    hidden(
        0, inputs / 16, [&](int k) { return in.template load<AsLeft>(row, 16 * k); }, out);
  }
  __device__ void second_hidden(const Hidden& in, Hidden& out) const {
    Sums sums[kPieces][2];
    const Values<kSplit> w = weights(1);
#pragma unroll
    for (int p = 0; p < kPieces; ++p) {
      for (int h = 0; h < 2; ++h) sums[p][h] = from_bias(1, 16 * p + 8 * h);
#pragma unroll
      for (int k = 0; k < kPieces; ++k) {
        const Pieces<kSplit> right = w.template load<ToOutputs>(16 * p, 16 * k);
        multiply(sums[p][0], in[k], right, 0);
        multiply(sums[p][1], in[k], right, 1);
      }
    }
    cut_off(sums, out);
  }

  // Calls f(output, row of the tile, half, k): which output and row the thread's sum k of a half is of.
  template <class F>
  __device__ void for_outputs(const F& f) const {
    const int g = lane_id() / 4, t = lane_id() % 4;
#pragma unroll
    for (int h = 0; h < 2; ++h)
#pragma unroll
      for (int e = 0; e < 4; ++e) f(8 * h + 2 * t + e % 2, row + g + e / 2 * 8, h, e);
  }

  __device__ void forward(std::uint32_t first, std::uint32_t count) const {
    load_inputs(first, count);
    Hidden values;
    first_hidden(values);
    if (kHidden > 1) {
      Hidden next;
      second_hidden(values, next);
#pragma unroll
      for (int p = 0; p < kPieces; ++p) values[p] = next[p];
    }
    Sums sums[2] = {from_bias(kHidden, 0), from_bias(kHidden, 8)};
    const Values<kSplit> w = weights(kHidden);
#pragma unroll
    for (int k = 0; k < kPieces; ++k) {
      const Pieces<kSplit> right = w.template load<ToOutputs>(0, 16 * k);
      multiply(sums[0], values[k], right, 0);
      multiply(sums[1], values[k], right, 1);
    }
    const int outputs = a.network.layer[kHidden].outputs;
    for_outputs([&](int o, int r, int h, int e) {
      const std::uint32_t n = first + std::uint32_t(r);
      if (o < outputs && n < count)
        a.out[std::size_t(o) * a.capacity + n] = network_output(a.output, o, sums[h].value[e]);
    });
    __syncwarp();  // the inputs may be overwritten
  }

  // -- Backward

  // Gradients with respect to the raw outputs.
  __device__ Pieces<kSplit> output_slopes(std::uint32_t first, std::uint32_t count) const {
    const int outputs = a.network.layer[kHidden].outputs;
    Sums slopes[2];
    for_outputs([&](int o, int r, int h, int e) {
      const std::uint32_t n = first + std::uint32_t(r);
      float slope = 0;
      if (o < outputs && n < count) {
        const std::size_t at = std::size_t(o) * a.capacity + n;
        slope = a.d_out[at] * network_output_slope(a.output, o, a.out[at]);
      }
      slopes[h].value[e] = slope;
    });
    return pieces_of<kSplit>(slopes[0], slopes[1]);
  }

  // Slopes of the values below layer l, 16 from `column` on; slopes: of the layer's outputs, kCount pieces.
  template <int kCount>
  __device__ void slopes_below(int l, int column, const Pieces<kSplit> (&slopes)[kCount],
                               Sums (&sums)[2]) const {
    const Values<kSplit> w = weights(l);
    sums[0] = sums[1] = Sums{};
#pragma unroll
    for (int k = 0; k < kCount; ++k) {
      const Pieces<kSplit> right = w.template load<ToInputs>(16 * k, column);
      multiply(sums[0], slopes[k], right, 0);
      multiply(sums[1], slopes[k], right, 1);
    }
  }

  // The same for hidden values: zero where ReLU cut the value off.
  template <int kCount>
  __device__ void hidden_slopes(int l, const Pieces<kSplit> (&slopes)[kCount], const Hidden& values,
                                Hidden& out) const {
#pragma unroll
    for (int p = 0; p < kPieces; ++p) {
      Sums sums[2];
      slopes_below(l, 16 * p, slopes, sums);
#pragma unroll
      for (int k = 0; k < 4; ++k) {
        const std::uint32_t value = values[p].part[0].part[k];
        float* pair = sums[k / 2].value + k % 2 * 2;
        if ((value & 0xffffu) == 0) pair[0] = 0;
        if (value >> 16 == 0) pair[1] = 0;
      }
      out[p] = pieces_of<kSplit>(sums[0], sums[1]);
    }
  }

  // A warp's sums of a layer's gradients over all of its block's tiles: of 16 outputs, kTiles times 8 inputs,
  // and the biases.
  template <int kOutputPieces, int kTiles>
  struct LayerSums {
    static constexpr int kStep = kWarps / kOutputPieces;  // warps that share 16 outputs
    Sums weights[kTiles], biases;
    __device__ int outputs() const { return int(threadIdx.x) / 32 % kOutputPieces * 16; }
    __device__ int inputs(int tile) const {
      return (int(threadIdx.x) / 32 / kOutputPieces + kStep * tile) * 8;
    }
  };

  template <int kOutputPieces, int kTiles>
  __device__ void add_gradients(LayerSums<kOutputPieces, kTiles>& sums, const Values<kSplit>& slopes,
                                const Values<kSplit>& values, int count) const {
    const bool own_biases = sums.inputs(0) == 0;
    const std::uint32_t ones = lane_id() < 4 ? 0x3f803f80u : 0u;  // the first column
#pragma unroll 2
    for (int r = 0; r < kRows; r += 32) {
      const Pieces<kSplit> left[2] = {slopes.template load<AsLeftTransposed>(r, sums.outputs()),
                                      slopes.template load<AsLeftTransposed>(r + 16, sums.outputs())};
#pragma unroll
      for (int tile = 0; tile < kTiles; ++tile) {
        if (sums.inputs(tile) >= count) break;
        const Pieces<kSplit> right = values.template load<Of32Rows>(r, sums.inputs(tile));
        multiply(sums.weights[tile], left[0], right, 0);
        multiply(sums.weights[tile], left[1], right, 1);
      }
      if (!own_biases) continue;
#pragma unroll
      for (const Pieces<kSplit>& half : left)
        for (const Piece& part : half.part) likeness::cuda::multiply(sums.biases, part, ones, ones);
    }
  }

  // to: this block's row of the work space, from the layer's first parameter on.
  template <int kOutputPieces, int kTiles>
  __device__ void store_gradients(const LayerSums<kOutputPieces, kTiles>& sums, const DeviceLayer& layer,
                                  float* to) const {
    const int g = lane_id() / 4, t = lane_id() % 4;
#pragma unroll
    for (int e = 0; e < 4; ++e) {
      const int o = sums.outputs() + g + e / 2 * 8;
      if (o >= layer.outputs) continue;
#pragma unroll
      for (int tile = 0; tile < kTiles; ++tile) {
        const int i = sums.inputs(tile) + 2 * t + e % 2;
        if (i < layer.inputs) to[o * layer.inputs + i] = sums.weights[tile].value[e];
      }
      if (sums.inputs(0) == 0 && t == 0 && e % 2 == 0)
        to[layer.outputs * layer.inputs + o] = sums.biases.value[e];
    }
  }

  // Gradients of the codes of the warp's samples: those of one view are summed before they are added.
  __device__ void add_codes(const float* codes, std::uint32_t first, std::uint32_t count) const {
    const int lane = lane_id(), own = lane % 16, half = lane / 16;
    const std::uint32_t n = first + std::uint32_t(row + own);
    const std::int32_t view = n >= count ? -1 : a.view ? a.view[n] : 0;
    unsigned left = __ballot_sync(~0u, view >= 0);
    while (left != 0) {
      const std::int32_t now = __shfl_sync(~0u, view, __ffs(int(left)) - 1);
      for (int k = half; k < (a.code_count + 1) / 2 * 2; k += 2) {
        float sum = view == now && k < a.code_count ? codes[k * 16 + own] : 0.0f;
        for (int step = 8; step > 0; step /= 2) sum += __shfl_xor_sync(~0u, sum, step);
        if (own == 0 && k < a.code_count)
          add_to(a.d_codes + std::size_t(now) * std::size_t(a.code_count) + k, sum);
      }
      left &= ~__ballot_sync(~0u, view == now);
    }
  }

  __device__ void input_gradients(const Hidden& slopes, std::uint32_t first, std::uint32_t count) const {
    const int codes = a.column_count + a.direction_count, used = a.network.layer[0].inputs;
    // Reuses the block's hidden values, which are no longer read; a warp's own rows.
    float* own_codes = reinterpret_cast<float*>(tile_hidden().at + row * kStride);
    for (int column = 0; column < used; column += 16) {
      if (column >= a.column_count && !a.d_codes) break;
      Sums sums[2];
      slopes_below(0, column, slopes, sums);
      for_outputs([&](int k, int r, int h, int e) {
        const int i = column + k;
        const std::uint32_t n = first + std::uint32_t(r);
        if (n >= count) return;
        if (i < a.column_count && a.d_columns) {
          float* to = a.d_columns + std::size_t(i) * a.capacity + n;
          *to = a.add_columns ? *to + sums[h].value[e] : sums[h].value[e];
        } else if (a.d_codes && i >= codes && i < codes + a.code_count) {
          own_codes[(i - codes) * 16 + r - row] = sums[h].value[e];
        }
      });
    }
    if (!a.d_codes) return;
    __syncwarp();
    add_codes(own_codes, first, count);
  }

  __device__ void backward(std::uint32_t count) const {
    constexpr int kLastTiles = (kWidth / 8 + kWarps - 1) / kWarps, kStep = kWarps / kPieces;
    LayerSums<1, kLastTiles> last{};
    LayerSums<kPieces, kWidth / 8 / kStep> middle{};
    LayerSums<kPieces, kMaxInputs / 8 / kStep> lowest{};
    const Values<kSplit> in = tile_inputs(), values = tile_hidden(), slopes = tile_slopes();
    for (std::uint32_t first = blockIdx.x * kRows; first < count; first += gridDim.x * kRows) {
      load_inputs(first, count);
      Hidden hidden[kHidden];
      first_hidden(hidden[0]);
      if (kHidden > 1) second_hidden(hidden[0], hidden[kHidden - 1]);
      const Pieces<kSplit> out[1] = {output_slopes(first, count)};
      slopes.store(out[0], row, 0);
#pragma unroll
      for (int p = 0; p < kPieces; ++p) values.store(hidden[kHidden - 1][p], row, 16 * p);
      __syncthreads();
      add_gradients(last, slopes, values, kWidth);
      Hidden below;
      hidden_slopes(kHidden, out, hidden[kHidden - 1], below);
      __syncthreads();
#pragma unroll
      for (int p = 0; p < kPieces; ++p) slopes.store(below[p], row, 16 * p);
      if (kHidden > 1) {
#pragma unroll
        for (int p = 0; p < kPieces; ++p) values.store(hidden[0][p], row, 16 * p);
        __syncthreads();
        add_gradients(middle, slopes, values, kWidth);
        Hidden lower;
        hidden_slopes(1, below, hidden[0], lower);
        __syncthreads();
#pragma unroll
        for (int p = 0; p < kPieces; ++p) below[p] = lower[p], slopes.store(below[p], row, 16 * p);
      }
      __syncthreads();
      add_gradients(lowest, slopes, in, inputs);
      input_gradients(below, first, count);
      __syncthreads();
    }
    const DeviceNetwork& network = a.network;
    std::uint32_t parameters = 0;
    for (int l = 0; l <= kHidden; ++l) parameters += layer_parameters(network.layer[l]);
    float* to = a.partial + std::size_t(blockIdx.x) * parameters;
    store_gradients(lowest, network.layer[0], to);
    to += layer_parameters(network.layer[0]);
    if (kHidden > 1) store_gradients(middle, network.layer[1], to), to += layer_parameters(network.layer[1]);
    store_gradients(last, network.layer[kHidden], to);
  }
};

#endif

template <int kWidth, int kHidden, bool kSplit>
__global__ void __launch_bounds__(kThreads, kWidth == 32 ? 3 : 2)
    forward_kernel(const __grid_constant__ NetworkArgs args) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 800
  const std::uint32_t count = *args.count;
  if (blockIdx.x * kRows >= count) return;
  const MatrixNetwork<kWidth, kHidden, kSplit> network(args, false);
  network.load_weights();
  for (std::uint32_t first = blockIdx.x * kRows; first < count; first += gridDim.x * kRows)
    network.forward(first, count);
#endif
}

template <int kWidth, int kHidden, bool kSplit>
__global__ void __launch_bounds__(kThreads, 1) backward_kernel(const __grid_constant__ NetworkArgs args) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 800
  const std::uint32_t count = *args.count;
  if (blockIdx.x * kRows >= count) return;
  const MatrixNetwork<kWidth, kHidden, kSplit> network(args, true);
  network.load_weights();
  network.backward(count);
#endif
}

// Adds the rows of the work space that the blocks filled: 32 parameters per block, 8 threads for their rows.
__global__ void __launch_bounds__(256) sum_kernel(const __grid_constant__ NetworkArgs args, unsigned blocks) {
  __shared__ float sums[8][32];
  const std::uint32_t count = *args.count, tiles = (count + kRows - 1) / kRows;
  const std::uint32_t rows = tiles < blocks ? tiles : blocks;
  std::uint32_t all = 0;
  for (int l = 0; l < args.network.layers; ++l) all += layer_parameters(args.network.layer[l]);
  const std::uint32_t p = blockIdx.x * 32 + threadIdx.x;
  float sum = 0;
  if (p < all)
    for (std::uint32_t r = threadIdx.y; r < rows; r += 8) sum += args.partial[std::size_t(r) * all + p];
  sums[threadIdx.y][threadIdx.x] = sum;
  __syncthreads();
  if (threadIdx.y > 0 || p >= all) return;
  for (int k = 1; k < 8; ++k) sum += sums[k][threadIdx.x];
  std::uint32_t at = p;
  for (int l = 0; l < args.network.layers; ++l) {
    const DeviceLayer& layer = args.network.layer[l];
    const std::uint32_t weights = std::uint32_t(layer.outputs * layer.inputs);
    if (at < layer_parameters(layer)) {
      args.gradients[at < weights ? layer.weights + at : layer.biases + (at - weights)] += sum;
      return;
    }
    at -= layer_parameters(layer);
  }
}

template <int kWidth, int kHidden, bool kSplit>
cudaError_t queue(const Launch& launch, const NetworkArgs& args, std::size_t items, bool backward,
                  bool& taken) {
  const std::size_t shared =
      std::size_t(matrix_memory<kWidth, kHidden, kSplit>(padded(args.network.layer[0].inputs), backward).end);
  if (shared > launch.facts.shared_bytes) return cudaSuccess;
  taken = true;
  const auto kernel =
      backward ? backward_kernel<kWidth, kHidden, kSplit> : forward_kernel<kWidth, kHidden, kSplit>;
  cudaError_t failed = cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, int(shared));
  if (failed != cudaSuccess) return failed;
  int at_once = 0;
  failed = cudaOccupancyMaxActiveBlocksPerMultiprocessor(&at_once, kernel, kThreads, shared);
  if (failed != cudaSuccess) return failed;
  const unsigned tiles = blocks_of(items, unsigned(kRows));
  unsigned most = unsigned(launch.facts.multiprocessors) * unsigned(at_once > 0 ? at_once : 1);
  if (backward && most > args.partial_blocks) most = args.partial_blocks;
  const unsigned blocks = tiles < most ? tiles : most;
  kernel<<<blocks, unsigned(kThreads), shared, launch.stream>>>(args);
  failed = cudaGetLastError();
  if (failed != cudaSuccess || !backward) return failed;
  std::uint32_t parameters = 0;
  for (int l = 0; l < args.network.layers; ++l) parameters += layer_parameters(args.network.layer[l]);
  sum_kernel<<<blocks_of(parameters, 32), dim3(32, 8), 0, launch.stream>>>(args, blocks);
  return cudaGetLastError();
}

bool is_covered(const Launch& launch, const NetworkArgs& args, bool backward) {
  const DeviceNetwork& network = args.network;
  if (args.precision == NetworkPrecision::single || !launch.facts.matrix_units) return false;
  if (network.layers < 2 || network.layers > 3 || network.layer[0].outputs > 64) return false;
  if (padded(network.layer[0].inputs) > kMaxInputs || network.layer[network.layers - 1].outputs > kOutputs)
    return false;
  if (args.precision == NetworkPrecision::split && network.layers != 2) return false;
  if (network.layers == 3 && network.layer[1].outputs != network.layer[0].outputs) return false;
  if (backward && (!args.partial || (args.d_codes && args.code_count > 16))) return false;
  return true;
}

}  // namespace

cudaError_t matrix_network(const Launch& launch, const NetworkArgs& args, std::size_t items, bool backward,
                           bool& taken) {
  taken = false;
  if (!is_covered(launch, args, backward)) return cudaSuccess;
  const bool narrow = args.network.layer[0].outputs <= 32;
  if (args.precision == NetworkPrecision::split)
    return narrow ? queue<32, 1, true>(launch, args, items, backward, taken)
                  : queue<64, 1, true>(launch, args, items, backward, taken);
  if (args.network.layers == 2)
    return narrow ? queue<32, 1, false>(launch, args, items, backward, taken)
                  : queue<64, 1, false>(launch, args, items, backward, taken);
  return narrow ? queue<32, 2, false>(launch, args, items, backward, taken)
                : queue<64, 2, false>(launch, args, items, backward, taken);
}

}  // namespace likeness::cuda
