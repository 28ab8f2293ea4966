// The parts of a field in bfloat16 and their kernels by intrinsics (AVX-512 BF16), which Highway 1.0 does not
// know: field_bf16.cpp, called from field_simd.cpp for whole tiles. Internal to core/field.
//
// A pair of neighbouring inputs of one sample is one 32-bit word, the first in the lower half, which is what
// the processor's dot product takes. Sums are single precision.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/field/field_layout.h"

namespace likeness {

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

struct Bf16Parts {
  const std::uint16_t* tables = nullptr;  // as the parameters' tables
  PackedNetwork density, colour;
};

// Whether the functions below may be called.
bool cpu_has_bf16();
// Whole entries of 2, 4 or 8 features can be read.
bool grid_has_bf16(const GridConfig& grid);

void round_table(const float* from, std::size_t count, std::uint16_t* to);

// rows (features, kTile): a level's features at the points, `point` its rows of kTile coordinates.
void encode_tile_bf16(const GridLevel& level, const GridConfig& grid, const std::uint16_t* tables,
                      const float* const* point, float* rows);

// out (outputs, kTile) = the first outputs of the network at `in` (inputs, kTile). Scratch, 64-byte aligned:
// words (pairs of the first layer's inputs, kTile) and twice (pairs of the widest hidden layer, kTile).
struct PairScratch {
  std::uint32_t *in, *hidden[2];
};
void network_bf16(const PackedNetwork& network, const float* in, const PairScratch& scratch,
                  std::size_t outputs, float* out);

// -- The same in plain loops, for tests on any machine.
void encode_tile_bf16_reference(const GridLevel& level, const GridConfig& grid, const std::uint16_t* tables,
                                const float* const* point, float* rows);
void network_bf16_reference(const PackedNetwork& network, const float* in, std::size_t outputs, float* out);

}  // namespace likeness
