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
  FieldConfig config;             // of the remaining field: `local` as its conditions, no latents
  FieldLayout layout;             // its layers lie in `networks`
  const float* tables = nullptr;  // the field's own
  std::vector<float> networks;
  std::vector<float> local;  // psi's entries that act only in a region; empty: all of them are 0
  std::shared_ptr<const RoundedTables> rounded;  // the field's, or its own
  std::optional<Bf16Parts> bf16;
};

}  // namespace likeness
