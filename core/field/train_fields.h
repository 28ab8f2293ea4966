// The passes of training: forward, loss and backward. Parallel inside; the results do not depend on the
// number of threads. Fast path with Highway (field_simd.cpp,
// train_simd.cpp), whose reference is field_reference.h.
//
// The backward pass needs what the networks computed in the forward pass, about a kilobyte per sample. So
// that it stays in the cache, samples come in blocks, each a few rays complete in all fields: a block goes
// forward, its loss is computed, and it goes backward. Only features and their gradients cross the whole
// batch, since hash tables need one level at a time for all samples.
//
// In bfloat16 (precision.h) the tables and weights are rounded again at the start of every step, so that no
// copy can be out of date.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/field/evaluate.h"
#include "core/field/field.h"
#include "core/field/precision.h"

namespace likeness {

// Memory reused between steps, about 270 bytes per sample of the standard field, and in bfloat16 half the
// tables'. One per field being trained.
struct FieldTape;
std::shared_ptr<FieldTape> make_tape();

// Gradients of the loss, accumulated by train_fields and consumed (zeroed) by adam_step.
struct FieldGradients {
  std::vector<float> parameters;      // laid out as Field::parameters
  std::vector<std::uint8_t> touched;  // (tables / kTableLine) 1: this line of the tables has a gradient
  std::vector<float> latents;         // (views, L)
  std::vector<float> conditions;      // (views, K), filled if want_conditions
  std::vector<float> x, y, z;         // (N) of the last batch, filled if want_positions
  bool want_conditions = false,
       want_positions = false;  // each costs a little; positions about a second encoding
};
// Zeroed gradients for a field and a number of rows of conditions and latents.
FieldGradients make_gradients(const Field& field, std::size_t views);
void clear_gradients(FieldGradients& gradients);

// One field's part in a step. Refers to its owner's data.
struct FieldStep {
  const Field& field;
  FieldInputs inputs;
  std::span<const std::size_t>
      ends;                     // (blocks) samples of block b end before ends[b]; the last is inputs.count
  FieldOutputs& out;            // resized to inputs.count
  FieldOutputGradients slopes;  // of a block's samples, valid once its loss is computed
  FieldTape& tape;
  FieldGradients& gradients;  // added to; made for this field and at least as many views as the inputs use
  FieldPrecision precision = FieldPrecision::bf16;
};

// `loss`: called once for every block, on any thread, when the outputs of its samples are ready in all
// fields; fills their slopes. It must not run parallel loops of its own. Without it the slopes are already
// given. All steps have the same number of blocks.
using BlockLoss = std::function<void(std::size_t block)>;
void train_fields(std::span<const FieldStep> steps, const BlockLoss& loss);

// A batch of one field whose slopes are known beforehand.
void train_field(const Field& field, const FieldInputs& inputs, FieldOutputs& out,
                 const FieldOutputGradients& slopes, FieldTape& tape, FieldGradients& gradients,
                 FieldPrecision precision = FieldPrecision::bf16);

}  // namespace likeness
