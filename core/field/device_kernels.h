// Arguments of the field's kernels on a device (core/device). Plain C++17 with pointers and sizes.
//
// A batch has room for `capacity` samples, of which `*count` are valid: the count is on the device, so that a
// recorded step serves every batch. An array "(rows, capacity)" holds one row of samples per component.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/field/field_levels.h"

namespace likeness {

constexpr int kMaxLevels = 32, kMaxLayers = 3;

struct DeviceGrid {
  std::int32_t dimensions, levels, features;
  GridLevel level[kMaxLevels];
};

// -- Grids. Items: samples times levels, the samples of one level beside each other.

struct EncodeArgs {
  DeviceGrid grid;
  const float* parameters;
  const float* point[3];  // (capacity) in [0, 1], clamped to it
  float* features;        // (levels x features, capacity)
  const std::uint32_t* count;
  std::uint32_t capacity;
};

// With slopes of the point, items are samples, each going through all levels.
struct EncodeBackwardArgs {
  DeviceGrid grid;
  const float* parameters;
  const float* point[3];
  const float* d_features;  // (levels x features, capacity)
  float* d_point[3];        // (capacity), all set, or all null
  float* gradients;         // as the parameters; added to
  const std::uint32_t* count;
  std::uint32_t capacity;
};

// -- Networks. Items: samples; where a block takes them through plain loops (network_math.h), `rows` at a
// time.

// A layer in a block's shared memory: weights (outputs padded to 16, stride), stride = inputs padded to 16,
// plus 8 so that the rows of a matrix start in different banks.
struct DeviceLayer {
  std::int32_t inputs, outputs, stride;
  std::uint32_t weights, biases;  // offsets into the parameters
  std::uint32_t shared_weights, shared_biases;
};

struct DeviceNetwork {
  std::int32_t layers;
  DeviceLayer layer[kMaxLayers];
  std::uint32_t weight_count, bias_count;  // in shared memory
};

enum class NetworkOutput : std::int32_t {
  slice,    // (tanh + 1) / 2
  density,  // the first is a density, the others are unchanged
  colour    // sigmoid
};
// split: factors in two bfloat16 parts each, if there are matrix units; otherwise single.
enum class NetworkPrecision : std::int32_t { single, bf16, split };

struct NetworkArgs {
  DeviceNetwork network;
  NetworkOutput output;
  NetworkPrecision precision;  // of products; sums are in single precision
  std::int32_t rows;           // a multiple of 16
  const float* parameters;
  // The input: rows of features, then harmonics of the direction, then a code.
  const float* columns;  // (column_count, capacity)
  std::int32_t column_count;
  std::int32_t direction_count;  // 9 or 0
  const float* direction[3];     // (capacity)
  std::int32_t code_count;
  const float* codes;        // (views, code_count), or null: zeros
  const std::int32_t* view;  // (capacity), or null: row 0
  const std::uint32_t* count;
  std::uint32_t capacity;
  float* out;  // (outputs, capacity)

  // Backward only.
  const float* d_out;        // (outputs, capacity): by what `out` holds
  float* d_columns;          // (column_count, capacity), or null
  std::int32_t add_columns;  // 1: added to, else set
  float* d_codes;            // (views, code_count), added to, or null
  float* gradients;          // as the parameters; added to
  std::int32_t shared_sums;  // 1: a block sums its gradients in shared memory first
  // (partial_blocks, the network's parameters) sums of blocks on the matrix units; null without training and
  // in single precision.
  float* partial;
  std::uint32_t partial_blocks;
};

// -- Adam. Nothing is updated if the loss of the step is not finite, or no sample fell into the field.

// Numbers that change from step to step. One in the device's memory.
struct StepNumbers {
  std::uint32_t count[2];  // samples of each field
  std::uint32_t rays;
  float loss_scale;       // 1 / (channels x rays)
  float table_rate;       // without the correction for a line's age
  float table_keep;       // of a line's values, before its step
  float network_rate[2];  // of each field, corrected
  float code_rate;        // corrected
};

// Results of a step.
struct StepSums {
  double error;            // squared, over rays and channels
  std::uint32_t count[2];  // samples of each field, if chosen on the device
};

struct AdamMoments {
  float beta1, beta2, epsilon;
};

// Items: lines of the tables. Those without any gradient are unchanged.
struct AdamLinesArgs {
  float *parameters, *gradients, *first, *second;
  std::uint32_t* line_steps;
  const float* corrections;  // (correction_count): factor on the rate of a line's n-th step
  std::uint32_t correction_count;
  AdamMoments moments;
  const StepNumbers* numbers;
  const StepSums* sums;
  std::uint32_t lines;
};

// Items: parameters from `begin` to `end`, none of them of a table.
struct AdamNetworksArgs {
  float *parameters, *gradients, *first, *second;
  AdamMoments moments;
  const StepNumbers* numbers;
  const StepSums* sums;
  std::int32_t field;
  std::uint32_t begin, end;
};

// One block. Codes of views are stepped, and then those of the first `centred` have zero mean.
struct AdamCodesArgs {
  float* codes;           // (2 views, length), the first half is stepped
  float* gradients;       // (2 views, length), cleared
  float *first, *second;  // (views, length)
  float penalty;          // its mean square's weight in the loss
  std::uint32_t views, centred, length;
  AdamMoments moments;
  const StepNumbers* numbers;
  const StepSums* sums;
};

}  // namespace likeness
