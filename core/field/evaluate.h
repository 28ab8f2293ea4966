// The field on batches of samples. Parallel inside; the results do not depend on the number of threads. Fast
// path with Highway (field_simd.cpp), whose reference is field_reference.h. Training: train_fields.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/field/field.h"
#include "core/field/precision.h"

namespace likeness {

// Batches from 64k samples reach full speed. `out` is resized to inputs.count. Positions outside [0, 1] are
// clamped to the cube. A null direction pointer means directions are (0, 0, 1). With bf16, tables are rounded
// on every call unless the field's have been already (round_tables).
void evaluate_field(const Field& field, const FieldInputs& inputs, FieldOutputs& out,
                    FieldPrecision precision = FieldPrecision::exact);
// Density only: directions and latents are not read. For occupancy grids.
void evaluate_density(const Field& field, const FieldInputs& inputs, std::vector<float>& sigma);

// The same in two steps, for rays whose samples mostly contribute nothing to their colour: densities first,
// then the colours of those that count.
struct GeometryFeatures {
  std::vector<float> values;  // per sample, the colour network's inputs from the density network
};
void evaluate_density(const Field& field, const FieldInputs& inputs, std::vector<float>& sigma,
                      GeometryFeatures& geometry);
// chosen: samples of `inputs`, as given to the evaluate_density that filled `geometry`. Red, green and blue
// of `out` are resized to chosen.size() and equal evaluate_field's bit for bit; its sigma is left unchanged.
void evaluate_colour(const Field& field, const FieldInputs& inputs, const GeometryFeatures& geometry,
                     std::span<const std::uint32_t> chosen, FieldOutputs& out);

class ConditionedField;  // core/field/conditioned_field.h

// The same of a field under one condition; the inputs' views, conditions and latents are not read, and their
// weights of local conditions only where needs_local() says so.
void evaluate_density(const ConditionedField& field, const FieldInputs& inputs, std::vector<float>& sigma);
void evaluate_density(const ConditionedField& field, const FieldInputs& inputs, std::vector<float>& sigma,
                      GeometryFeatures& geometry);
void evaluate_colour(const ConditionedField& field, const FieldInputs& inputs,
                     const GeometryFeatures& geometry, std::span<const std::uint32_t> chosen,
                     FieldOutputs& out);

}  // namespace likeness
