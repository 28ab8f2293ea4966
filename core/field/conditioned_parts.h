// What a ConditionedField holds. Internal to core/field.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/field/field_bf16.h"
#include "core/field/field_layout.h"
#include "core/field/rounded_tables.h"

namespace likeness {

struct ConditionedParts {
  FieldConfig config;             // of the field that is left: `local` as its conditions, no latents
  FieldLayout layout;             // its layers lie in `networks`
  const float* tables = nullptr;  // the field's own
  std::vector<float> networks;
  std::vector<float> local;  // psi's entries that act in a region only; empty: all of them are 0
  std::shared_ptr<const RoundedTables> rounded;  // the field's, or of its own
  std::optional<Bf16Parts> bf16;
};

}  // namespace likeness
