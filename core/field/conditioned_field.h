// A field under one condition, ready for pictures: many small batches that share psi and have no latent code.
//
// Psi's contribution to the first layer it meets is the same for every sample, so it is folded into that
// layer's biases. Entries that act only in a region remain per sample, unless all of them are 0.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/field/evaluate.h"
#include "core/field/field.h"
#include "core/field/precision.h"

namespace likeness {

struct ConditionedParts;

class ConditionedField {
 public:
  // psi: (K) of the field. Refers to the field, which must not change meanwhile. Takes a few milliseconds
  // with bf16 unless its tables have been rounded before.
  ConditionedField(const Field& field, std::span<const float> psi, FieldPrecision precision);
  ~ConditionedField();
  ConditionedField(ConditionedField&&) noexcept;
  ConditionedField& operator=(ConditionedField&&) noexcept;

  const ConditionedParts& parts() const { return *parts_; }
  bool needs_local() const;  // whether an entry of psi that acts only in a region is not 0

 private:
  std::unique_ptr<ConditionedParts> parts_;
};

// As the functions of evaluate.h; the inputs' views, conditions and latents are not read, and their weights
// of local conditions only where needs_local() says so.
void evaluate_density(const ConditionedField& field, const FieldInputs& inputs, std::vector<float>& sigma);
void evaluate_density(const ConditionedField& field, const FieldInputs& inputs, std::vector<float>& sigma,
                      GeometryFeatures& geometry);
void evaluate_colour(const ConditionedField& field, const FieldInputs& inputs,
                     const GeometryFeatures& geometry, std::span<const std::uint32_t> chosen,
                     FieldOutputs& out);

}  // namespace likeness
