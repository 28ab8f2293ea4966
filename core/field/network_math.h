// A network for a tile of samples, all layers in one go, by a block of threads of a device. Plain C++17.
//
// Weights and the tile's values are in the block's shared memory; values are (component, sample) with rows of
// `row` samples, so that neighbouring threads are neighbouring samples. `Value` is the type that products
// read (float or bfloat16); sums, outputs and gradients of weights are in single precision.
//
// A Block offers index(), blocks(), for_each(count, f), where f(i) runs once for every i < count and all are
// done when it returns, and the three products of LoopProducts below. matrix_networks.cu does the same on
// matrix units.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/field/device_kernels.h"
#include "core/field/device_math.h"

namespace likeness {

LIKENESS_HOST_DEVICE constexpr std::int32_t padded(std::int32_t count) { return (count + 15) / 16 * 16; }
// A little more than the samples, so that rows start in different banks.
LIKENESS_HOST_DEVICE inline std::int32_t row_of(const NetworkArgs& a) { return a.rows + 16; }

constexpr std::size_t kBlockThreads = 128;

// Layout of shared memory, bytes.
struct NetworkMemory {
  std::size_t weights, biases, value[kMaxLayers], gradient[2], sums, bias_sums, codes, end;
};

LIKENESS_HOST_DEVICE inline NetworkMemory network_memory(const NetworkArgs& a, std::size_t value_bytes,
                                                         bool backward) {
  NetworkMemory m{};
  std::size_t at = 0;
  const auto take = [&](std::size_t bytes) {
    const std::size_t here = at;
    at += (bytes + 127) / 128 * 128;
    return here;
  };
  const std::size_t row = std::size_t(row_of(a));
  m.weights = take(a.network.weight_count * value_bytes);
  m.biases = take(a.network.bias_count * sizeof(float));
  std::int32_t widest = 0;
  for (int l = 0; l < a.network.layers; ++l) {
    m.value[l] = take(std::size_t(padded(a.network.layer[l].inputs)) * row * value_bytes);
    const std::int32_t width = padded(a.network.layer[l].outputs);
    widest = width > widest ? width : widest;
  }
  if (backward) {
    for (std::size_t& gradient : m.gradient) gradient = take(std::size_t(widest) * row * value_bytes);
    if (a.shared_sums) {
      m.sums = take(a.network.weight_count * sizeof(float));
      m.bias_sums = take(a.network.bias_count * sizeof(float));
    }
    if (a.d_codes) m.codes = take(std::size_t(a.code_count) * row * sizeof(float));
  }
  m.end = at;
  return m;
}

// Products by loops over for_each of the block that inherits them. Sizes are padded to 16.
template <class Derived>
struct LoopProducts {
  // finish(o, r, sum over i of in[i][r] * weights[o][i])
  template <class Value, class Finish>
  LIKENESS_HOST_DEVICE void product(const Value* in, const Value* weights, int stride, int inputs,
                                    int outputs, int rows, int row, const Finish& finish) {
    static_cast<Derived*>(this)->for_each(outputs / 4 * rows, [&](int item) {
      const int r = item % rows, o = item / rows * 4;
      float sum[4] = {0, 0, 0, 0};
      const Value* w = weights + std::size_t(o) * stride;
      for (int i = 0; i < inputs; ++i) {
        const float x = float(in[std::size_t(i) * row + r]);
        for (int k = 0; k < 4; ++k) sum[k] += float(w[k * stride + i]) * x;
      }
      for (int k = 0; k < 4; ++k) finish(o + k, r, sum[k]);
    });
  }
  // finish(i, r, sum over o of gradient[o][r] * weights[o][i])
  template <class Value, class Finish>
  LIKENESS_HOST_DEVICE void product_transposed(const Value* gradient, const Value* weights, int stride,
                                               int inputs, int outputs, int rows, int row,
                                               const Finish& finish) {
    static_cast<Derived*>(this)->for_each(inputs / 4 * rows, [&](int item) {
      const int r = item % rows, i = item / rows * 4;
      float sum[4] = {0, 0, 0, 0};
      for (int o = 0; o < outputs; ++o) {
        const float g = float(gradient[std::size_t(o) * row + r]);
        for (int k = 0; k < 4; ++k) sum[k] += float(weights[std::size_t(o) * stride + i + k]) * g;
      }
      for (int k = 0; k < 4; ++k) finish(i + k, r, sum[k]);
    });
  }
  // add(o, i, sum over r of gradient[o][r] * in[i][r]); an (o, i) belongs to one thread, whatever the tile
  template <class Value, class Add>
  LIKENESS_HOST_DEVICE void outer(const Value* gradient, const Value* in, int inputs, int outputs, int rows,
                                  int row, const Add& add) {
    static_cast<Derived*>(this)->for_each(outputs * inputs, [&](int item) {
      const int o = item / inputs, i = item % inputs;
      float sum = 0;
      for (int r = 0; r < rows; ++r)
        sum += float(gradient[std::size_t(o) * row + r]) * float(in[std::size_t(i) * row + r]);
      add(o, i, sum);
    });
  }
};

template <class Value>
struct NetworkTile {
  Value *weights, *value[kMaxLayers], *gradient[2];
  float *biases, *sums, *bias_sums, *codes;

  LIKENESS_HOST_DEVICE NetworkTile(const NetworkArgs& a, unsigned char* shared, bool backward) {
    const NetworkMemory m = network_memory(a, sizeof(Value), backward);
    weights = reinterpret_cast<Value*>(shared + m.weights);
    for (int l = 0; l < kMaxLayers; ++l) value[l] = reinterpret_cast<Value*>(shared + m.value[l]);
    for (int i = 0; i < 2; ++i) gradient[i] = reinterpret_cast<Value*>(shared + m.gradient[i]);
    biases = reinterpret_cast<float*>(shared + m.biases);
    sums = reinterpret_cast<float*>(shared + m.sums);
    bias_sums = reinterpret_cast<float*>(shared + m.bias_sums);
    codes = reinterpret_cast<float*>(shared + m.codes);
  }
};

// Component k of sample n's input.
LIKENESS_HOST_DEVICE inline float network_input(const NetworkArgs& a, int k, std::uint32_t n) {
  if (k < a.column_count) return a.columns[std::size_t(k) * a.capacity + n];
  k -= a.column_count;
  if (k < a.direction_count)
    return direction_harmonic(k, a.direction[0][n], a.direction[1][n], a.direction[2][n]);
  k -= a.direction_count;
  if (k >= a.code_count || !a.codes) return 0;
  return a.codes[std::size_t(a.view ? a.view[n] : 0) * a.code_count + k];
}

template <class Value, class Block>
LIKENESS_HOST_DEVICE void load_network(Block& block, const NetworkArgs& a, const NetworkTile<Value>& tile) {
  for (int l = 0; l < a.network.layers; ++l) {
    const DeviceLayer& layer = a.network.layer[l];
    const int outputs = padded(layer.outputs);
    block.for_each(outputs * layer.stride, [&](int item) {
      const int o = item / layer.stride, i = item % layer.stride;
      const bool there = o < layer.outputs && i < layer.inputs;
      const float w = there ? a.parameters[layer.weights + std::size_t(o) * layer.inputs + i] : 0.0f;
      tile.weights[layer.shared_weights + item] = Value(w);
    });
    block.for_each(outputs, [&](int o) {
      tile.biases[layer.shared_biases + o] = o < layer.outputs ? a.parameters[layer.biases + o] : 0.0f;
    });
  }
}

// The inputs of samples from `first` on, and all values except those of the last layer.
template <class Value, class Block>
LIKENESS_HOST_DEVICE void hidden_layers(Block& block, const NetworkArgs& a, const NetworkTile<Value>& tile,
                                        std::uint32_t first, std::uint32_t count) {
  const int row = row_of(a), inputs = a.network.layer[0].inputs;
  block.for_each(padded(inputs) * a.rows, [&](int item) {
    const int k = item / a.rows, r = item % a.rows;
    const std::uint32_t n = first + std::uint32_t(r);
    tile.value[0][k * row + r] = Value(k < inputs && n < count ? network_input(a, k, n) : 0.0f);
  });
  for (int l = 0; l + 1 < a.network.layers; ++l) {
    const DeviceLayer& layer = a.network.layer[l];
    const float* biases = tile.biases + layer.shared_biases;
    Value* out = tile.value[l + 1];
    block.product(tile.value[l], tile.weights + layer.shared_weights, layer.stride, padded(layer.inputs),
                  padded(layer.outputs), a.rows, row, [&](int o, int r, float sum) {
                    const float value = sum + biases[o];
                    out[o * row + r] = Value(value > 0 ? value : 0.0f);
                  });
  }
}

template <class Value, class Block>
LIKENESS_HOST_DEVICE void network_forward(Block& block, const NetworkArgs& a, unsigned char* shared) {
  const NetworkTile<Value> tile(a, shared, false);
  const std::uint32_t count = *a.count, rows = std::uint32_t(a.rows);
  if (block.index() * rows >= count) return;
  load_network(block, a, tile);
  const int last = a.network.layers - 1;
  const DeviceLayer& layer = a.network.layer[last];
  const float* biases = tile.biases + layer.shared_biases;
  for (std::uint32_t first = block.index() * rows; first < count; first += block.blocks() * rows) {
    hidden_layers(block, a, tile, first, count);
    block.product(tile.value[last], tile.weights + layer.shared_weights, layer.stride, padded(layer.inputs),
                  padded(layer.outputs), a.rows, row_of(a), [&](int o, int r, float sum) {
                    const std::uint32_t n = first + std::uint32_t(r);
                    if (o < layer.outputs && n < count)
                      a.out[std::size_t(o) * a.capacity + n] = network_output(a.output, o, sum + biases[o]);
                  });
  }
}

// Gradients of the codes: samples of one view are adjacent, so runs are summed before they are added.
template <class Block>
LIKENESS_HOST_DEVICE void add_codes(Block& block, const NetworkArgs& a, const float* codes,
                                    std::uint32_t first, std::uint32_t count) {
  const int row = row_of(a);
  block.for_each(a.code_count, [&](int k) {
    float sum = 0;
    std::int32_t view = -1;
    for (int r = 0; r < a.rows && first + std::uint32_t(r) < count; ++r) {
      const std::int32_t own = a.view ? a.view[first + std::uint32_t(r)] : 0;
      if (own != view && view >= 0) add_to(a.d_codes + std::size_t(view) * a.code_count + k, sum), sum = 0;
      view = own;
      sum += codes[k * row + r];
    }
    if (view >= 0) add_to(a.d_codes + std::size_t(view) * a.code_count + k, sum);
  });
}

// From the gradients of the layer's outputs: those of its weights and biases.
template <class Value, class Block>
LIKENESS_HOST_DEVICE void layer_gradients(Block& block, const NetworkArgs& a, const NetworkTile<Value>& tile,
                                          int l, const Value* gradient) {
  const DeviceLayer& layer = a.network.layer[l];
  const int row = row_of(a);
  block.for_each(layer.outputs, [&](int o) {
    float sum = 0;
    for (int r = 0; r < a.rows; ++r) sum += float(gradient[o * row + r]);
    if (a.shared_sums) {
      tile.bias_sums[layer.shared_biases + o] += sum;
    } else {
      add_to(a.gradients + layer.biases + o, sum);
    }
  });
  block.outer(gradient, tile.value[l], padded(layer.inputs), padded(layer.outputs), a.rows, row,
              [&](int o, int i, float sum) {
                if (a.shared_sums) {
                  tile.sums[layer.shared_weights + o * layer.stride + i] += sum;
                } else if (o < layer.outputs && i < layer.inputs) {
                  add_to(a.gradients + layer.weights + std::size_t(o) * layer.inputs + i, sum);
                }
              });
}

// From the gradients of the first layer's outputs: those of the input.
template <class Value, class Block>
LIKENESS_HOST_DEVICE void input_gradients(Block& block, const NetworkArgs& a, const NetworkTile<Value>& tile,
                                          const Value* gradient, std::uint32_t first, std::uint32_t count) {
  const DeviceLayer& layer = a.network.layer[0];
  const int row = row_of(a), codes = a.column_count + a.direction_count;
  block.product_transposed(gradient, tile.weights + layer.shared_weights, layer.stride, padded(layer.inputs),
                           padded(layer.outputs), a.rows, row, [&](int i, int r, float sum) {
                             const std::uint32_t n = first + std::uint32_t(r);
                             if (n >= count) return;
                             if (i < a.column_count && a.d_columns) {
                               float* to = a.d_columns + std::size_t(i) * a.capacity + n;
                               *to = a.add_columns ? *to + sum : sum;
                             } else if (a.d_codes && i >= codes && i < codes + a.code_count) {
                               tile.codes[(i - codes) * row + r] = sum;
                             }
                           });
  if (a.d_codes) add_codes(block, a, tile.codes, first, count);
}

// Adds what a block has summed.
template <class Value, class Block>
LIKENESS_HOST_DEVICE void add_sums(Block& block, const NetworkArgs& a, const NetworkTile<Value>& tile) {
  for (int l = 0; l < a.network.layers; ++l) {
    const DeviceLayer& layer = a.network.layer[l];
    block.for_each(layer.outputs * layer.inputs, [&](int item) {
      const int o = item / layer.inputs, i = item % layer.inputs;
      add_to(a.gradients + layer.weights + item, tile.sums[layer.shared_weights + o * layer.stride + i]);
    });
    block.for_each(layer.outputs, [&](int o) {
      add_to(a.gradients + layer.biases + o, tile.bias_sums[layer.shared_biases + o]);
    });
  }
}

// The hidden layers are computed again: that is cheaper than keeping them.
template <class Value, class Block>
LIKENESS_HOST_DEVICE void network_backward(Block& block, const NetworkArgs& a, unsigned char* shared) {
  const NetworkTile<Value> tile(a, shared, true);
  const std::uint32_t count = *a.count, rows = std::uint32_t(a.rows);
  if (block.index() * rows >= count) return;
  const int row = row_of(a), last = a.network.layers - 1;
  load_network(block, a, tile);
  if (a.shared_sums) {
    block.for_each(int(a.network.weight_count), [&](int i) { tile.sums[i] = 0; });
    block.for_each(int(a.network.bias_count), [&](int i) { tile.bias_sums[i] = 0; });
  }
  for (std::uint32_t first = block.index() * rows; first < count; first += block.blocks() * rows) {
    hidden_layers(block, a, tile, first, count);
    const int outputs = a.network.layer[last].outputs;
    block.for_each(padded(outputs) * a.rows, [&](int item) {
      const int o = item / a.rows, r = item % a.rows;
      const std::uint32_t n = first + std::uint32_t(r);
      float gradient = 0;
      if (o < outputs && n < count) {
        const std::size_t at = std::size_t(o) * a.capacity + n;
        gradient = a.d_out[at] * network_output_slope(a.output, o, a.out[at]);
      }
      tile.gradient[0][o * row + r] = Value(gradient);
    });
    for (int l = last; l >= 0; --l) {
      const Value* gradient = tile.gradient[(last - l) & 1];
      layer_gradients(block, a, tile, l, gradient);
      if (l == 0) {
        input_gradients(block, a, tile, gradient, first, count);
        break;
      }
      const DeviceLayer& layer = a.network.layer[l];
      Value* below = tile.gradient[(last - l + 1) & 1];
      const Value* value = tile.value[l];
      block.product_transposed(
          gradient, tile.weights + layer.shared_weights, layer.stride, padded(layer.inputs),
          padded(layer.outputs), a.rows, row, [&](int i, int r, float sum) {
            below[i * row + r] = float(value[i * row + r]) > 0 ? Value(sum) : Value(0.0f);
          });
    }
  }
  if (a.shared_sums) add_sums(block, a, tile);
}

}  // namespace likeness
