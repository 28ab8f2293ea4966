// The parts of a field in bfloat16 and their kernels with intrinsics (AVX-512 BF16), which Highway 1.0 does
// not support: grid_bf16.cpp and network_bf16.cpp, called from the kernels of Highway for whole tiles.
// Internal to core/field.
//
// A pair of neighbouring inputs of one sample is one 32-bit word, the first in the lower half, which is what
// the processor's dot product takes. Sums are single precision.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/field/field_layout.h"

namespace likeness {

struct PartialLayer;  // field_kernels.h

// To the nearest, ties to even.
std::uint16_t to_bf16(float value);
float from_bf16(std::uint16_t value);

// Weights in blocks of 8 outputs, filled up with zeros: (blocks, pairs of inputs, 8) words.
struct PackedLayer {
  int inputs = 0, outputs = 0;
  std::vector<std::uint32_t> weights;
  std::vector<float> biases;  // (outputs)
};
using PackedNetwork = std::vector<PackedLayer>;
PackedNetwork pack_network(const std::vector<DenseLayer>& layers, const float* parameters);
// Columns [first, first + count) of W, as rows, without biases.
PackedLayer pack_transposed(const DenseLayer& layer, const float* parameters, int first, int count);
// All columns of every layer but the first, which comes without weights.
PackedNetwork pack_transposed(const std::vector<DenseLayer>& layers, const float* parameters);

// W^T for the backward pass: a layer's outputs are its inputs here.
struct PackedSlopes {
  // Layers as those of the networks; the first ones without weights, since not all of their inputs need a
  // gradient, and not at the same time:
  PackedNetwork density, colour;
  PackedLayer density_position, density_rest, colour_geometry, colour_latents;
};
PackedSlopes pack_slopes(const FieldConfig& config, const FieldLayout& layout, const float* parameters);

struct Bf16Parts {
  const std::uint16_t* tables = nullptr;  // as the parameters' tables
  std::size_t exact_levels = 0;           // of the position grid, the first, that are read unrounded
  PackedNetwork density, colour;
  PackedSlopes slopes;  // of a field in training
};

// Whether the functions below may be called.
bool cpu_has_bf16();
// Whole entries of 2, 4 or 8 features can be read.
bool grid_has_bf16(const GridConfig& grid);

void round_table(const float* from, std::size_t count, std::uint16_t* to);

// rows (features, kTile): a level's features at the points, `point` its rows of kTile coordinates.
void encode_tile_bf16(const GridLevel& level, const GridConfig& grid, const std::uint16_t* tables,
                      const float* const* point, float* rows);

// Words, 64-byte aligned, of pairs of a network's inputs (pairs, kTile) and of pairs of its hidden layers'
// ReLU outputs (pairs of the widest, kTile).
struct PairRows {
  std::uint32_t *in = nullptr, *hidden[2] = {};
};
// out (outputs, kTile) = the first outputs of the network at `in` (inputs, kTile). Fills `words`.
void network_bf16(const PackedNetwork& network, const float* in, const PairRows& words, std::size_t outputs,
                  float* out);

// Scratch, 64-byte aligned: words (widest stride, kTile / 2), twice (pairs of the widest layer, kTile), and
// (widest layer, kTile / 2).
struct SlopeScratch {
  std::uint32_t *turned = nullptr, *pairs[2] = {}, *samples = nullptr;
};
// From g (outputs, kTile), the gradients of the output, adds those of all layers to `partial`. Gradients are
// rounded where they meet weights or inputs, and summed in single precision; those of biases are not rounded.
// Returns the words of pairs of the first layer's gradients, which are in the scratch.
const std::uint32_t* network_backward_bf16(const PackedNetwork& transposed, const PairRows& kept,
                                           const float* g, const std::vector<PartialLayer>& to,
                                           float* partial, const SlopeScratch& scratch);
// rows (outputs, kTile): gradients of the inputs that `transposed` was packed for, from what
// network_backward_bf16 returned.
void input_gradient_bf16(const PackedLayer& transposed, const std::uint32_t* g, float* rows);

// -- The same in plain loops, for tests on any machine.
void encode_tile_bf16_reference(const GridLevel& level, const GridConfig& grid, const std::uint16_t* tables,
                                const float* const* point, float* rows);
void network_bf16_reference(const PackedNetwork& network, const float* in, std::size_t outputs, float* out);

struct PlainGradients {
  std::vector<std::vector<float>> weights, biases;  // of a layer: (outputs, inputs), (outputs)
  std::vector<float> inputs;                        // (inputs, kTile)
};
PlainGradients network_backward_bf16_reference(const PackedNetwork& network, const float* in, const float* g);

}  // namespace likeness
