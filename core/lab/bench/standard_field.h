// The field that is timed, always the same so that figures can be compared between versions, machines and
// other programs: 16 levels of 2 features in 3-D, 2^16 entries; ambient 16 levels of 2 in 2-D, 2^14 entries;
// slice network 32 wide; density 64-64-16; colour 31-64-64-3 (15 geometry features, 9 harmonics of the
// direction, a code of 7). 24,960 floating-point operations a sample, of which psi's share is none: it is the
// same for a whole view.
#pragma once

#include <cstdint>
#include <vector>

#include "core/field/evaluate.h"
#include "core/field/field.h"

namespace likeness {

FieldConfig standard_field_config();
// With tables and biases of the size they have after training.
Field standard_field(std::uint32_t seed);

// Samples along rays through the cube, 16 a ray, and gradients of a loss by the outputs.
struct StandardBatch {
  std::size_t views = 0;
  std::vector<float> x, y, z, dx, dy, dz;      // (N)
  std::vector<std::int32_t> view;              // (N)
  std::vector<float> conditions, latents;      // (views, K), (views, L)
  std::vector<float> sigma, red, green, blue;  // (N) gradients

  FieldInputs inputs() const;
  FieldOutputGradients gradients() const;
};
StandardBatch standard_batch(const FieldConfig& config, std::size_t count, std::uint32_t seed);

}  // namespace likeness
