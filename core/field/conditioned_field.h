// A field under one condition, ready for pictures: many small batches that share psi and have no latent code.
//
// What psi adds to the first layer it meets is the same for every sample, so it becomes a part of that
// layer's biases. With `bf16`, tables and the density and colour networks are rounded to bfloat16 (8 bits of
// significand) and summed in single precision; w and its network H stay in single precision, since ambient
// levels turn a small error of w into a large one of a. That takes half the time and is about 3e-3 (relative
// L2) off, where single precision is 1e-6.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/field/evaluate.h"
#include "core/field/field.h"

namespace likeness {

enum class FieldPrecision { exact, bf16 };

// Whether this processor multiplies bfloat16 (AVX-512 BF16) and the field's grids have entries that are read
// as a whole. Elsewhere `bf16` means `exact`.
bool has_bf16(const FieldConfig& config);

// Rounds the tables for all pictures to come. Whatever changes the parameters later must reset
// `field.rounded`. Nothing where has_bf16 is false.
void round_tables(Field& field);

struct ConditionedParts;

class ConditionedField {
 public:
  // psi: (K) of the field. Refers to the field, which must not change meanwhile. Takes some milliseconds with
  // bf16 unless its tables have been rounded before.
  ConditionedField(const Field& field, std::span<const float> psi, FieldPrecision precision);
  ~ConditionedField();
  ConditionedField(ConditionedField&&) noexcept;
  ConditionedField& operator=(ConditionedField&&) noexcept;

  const ConditionedParts& parts() const { return *parts_; }

 private:
  std::unique_ptr<ConditionedParts> parts_;
};

// As the functions of evaluate.h; the inputs' views, conditions and latents are not read.
void evaluate_density(const ConditionedField& field, const FieldInputs& inputs, std::vector<float>& sigma);
void evaluate_density(const ConditionedField& field, const FieldInputs& inputs, std::vector<float>& sigma,
                      GeometryFeatures& geometry);
void evaluate_colour(const ConditionedField& field, const FieldInputs& inputs,
                     const GeometryFeatures& geometry, std::span<const std::uint32_t> chosen,
                     FieldOutputs& out);

}  // namespace likeness
