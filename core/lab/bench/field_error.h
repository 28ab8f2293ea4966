// How far the fast kernels are from the reference in double precision, on the same samples.
#pragma once

#include <cstddef>

#include "core/field/field.h"
#include "core/field/precision.h"
#include "core/lab/bench/standard_field.h"

namespace likeness {

// Relative L2 distances |fast - reference| / |reference|.
struct FieldError {
  double outputs = 0;        // the worst of density, red, green, blue
  double networks = 0;       // gradients: the worst block of weights or biases
  double tables = 0;         // gradients: the worst level
  double adam = 0;           // one step's change of the parameters, the worst block
  std::size_t left_out = 0;  // samples whose gradient hangs on rounding: a ReLU or a cell border within 1e-4
};
// In bfloat16 more samples than those left out fall on the other side of a ReLU: that is part of its error.
FieldError field_error(const Field& field, const StandardBatch& batch,
                       FieldPrecision precision = FieldPrecision::exact);

}  // namespace likeness
