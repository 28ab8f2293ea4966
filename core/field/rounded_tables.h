// A field's tables in bfloat16. Internal to core/field.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/field/aligned_floats.h"
#include "core/field/field.h"

namespace likeness {

struct RoundedTables {
  AlignedFloats memory;  // two values in each
  std::size_t count = 0;
  std::uint16_t* values() const { return reinterpret_cast<std::uint16_t*>(memory.data()); }
};

// `rounded` = the first `count` parameters.
void round_tables(const Field& field, std::size_t count, RoundedTables& rounded);

// The field's own, if it has been rounded beforehand, or new ones.
std::shared_ptr<const RoundedTables> tables_of(const Field& field, std::size_t count);

}  // namespace likeness
