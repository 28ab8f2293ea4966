// The number formats in which a field computes.
//
// With `bf16`, tables and the density and colour networks are rounded to bfloat16 (8 bits of significand) and
// summed in single precision; w and its network H stay in single precision, since ambient levels turn a small
// error of w into a large one of a. That takes half the time and is about 3e-3 (relative L2) off, compared
// with 1e-6 in single precision. Training rounds copies of the parameters, except the levels that H reads,
// and gradients where they meet weights or inputs; the parameters themselves, sums of gradients and their
// moments stay in single precision.
#pragma once

#include "core/field/field.h"

namespace likeness {

enum class FieldPrecision { exact, bf16 };

// Whether this processor multiplies bfloat16 (AVX-512 BF16) and the field's grids have entries that can be
// read whole. Elsewhere `bf16` means `exact`.
bool has_bf16(const FieldConfig& config);

// Rounds the tables for all pictures to come. Code that changes the parameters later must reset
// `field.rounded`. Does nothing if has_bf16 is false.
void round_tables(Field& field);

}  // namespace likeness
