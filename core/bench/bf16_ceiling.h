// What one core does in dot products of bf16 pairs, for processors that have them (x86 with AVX512-BF16).
// Pictures use them; training and the timed passes are in single precision.
#pragma once

#include <optional>

namespace likeness {

// 1e9 operations a second of one core, four to a pair of products and their sum; empty without the
// instruction.
std::optional<double> measure_bf16_gflops(double seconds);

}  // namespace likeness
