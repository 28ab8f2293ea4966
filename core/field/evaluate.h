// The field on batches of samples: inference, and the forward and backward passes of training. Parallel
// inside; the results do not depend on the number of threads. Fast path with Highway (field_simd.cpp), whose
// reference is field_reference.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/field/field.h"

namespace likeness {

// What forward keeps for backward, and scratch reused between steps. One per field being trained; its memory
// is about 1.3 KB a sample of the largest batch seen.
struct FieldTape;
std::shared_ptr<FieldTape> make_tape();

// Gradients of the loss, accumulated by backward_field and consumed (zeroed) by adam_step.
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

// Batches from 64k samples reach full speed; 131k is a good step for training. `out` is resized to
// inputs.count. Positions outside [0, 1] are clamped to the cube. A null direction pointer means directions
// are (0, 0, 1).
void evaluate_field(const Field& field, const FieldInputs& inputs, FieldOutputs& out);
// Density only: directions and latents are not read. For occupancy grids.
void evaluate_density(const Field& field, const FieldInputs& inputs, std::vector<float>& sigma);

// The same in two steps, for rays whose samples mostly add nothing to their colour: densities first, then the
// colours of those that count.
struct GeometryFeatures {
  std::vector<float> values;  // per sample what the colour network takes from the density network
};
void evaluate_density(const Field& field, const FieldInputs& inputs, std::vector<float>& sigma,
                      GeometryFeatures& geometry);
// chosen: samples of `inputs`, as given to the evaluate_density that filled `geometry`. Red, green and blue
// of `out` are resized to chosen.size() and equal evaluate_field's bit for bit; its sigma is left alone.
void evaluate_colour(const Field& field, const FieldInputs& inputs, const GeometryFeatures& geometry,
                     std::span<const std::uint32_t> chosen, FieldOutputs& out);

void forward_field(const Field& field, const FieldInputs& inputs, FieldOutputs& out, FieldTape& tape);
// `inputs` and `field` as given to the forward_field that filled the tape. Adds to `gradients`, which must
// have been made for this field and at least as many views as the inputs use.
void backward_field(const Field& field, const FieldInputs& inputs,
                    const FieldOutputGradients& output_gradients, FieldTape& tape, FieldGradients& gradients);

}  // namespace likeness
