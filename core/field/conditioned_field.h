// A field under one condition, ready for pictures: many small batches that share psi and have no latent code
// (evaluate.h).
//
// Psi's contribution to the first layer it meets is the same for every sample, so it is folded into that
// layer's biases. Entries that act only in a region remain per sample, unless all of them are 0.
#pragma once

#include <memory>
#include <span>

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

}  // namespace likeness
