// The field written plainly, one sample at a time, in float or double: the reference for the SIMD and CUDA
// kernels and for finite differences. Slow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/field/field.h"

namespace likeness {

template <class Real>
struct ReferenceSamples {
  std::vector<Real> x, y, z;       // (N)
  std::vector<Real> dx, dy, dz;    // (N)
  std::vector<std::int32_t> view;  // (N)
  std::vector<Real> conditions;    // (views, K)
  std::vector<Real> latents;       // (views, L); empty: zero codes
  std::vector<Real> local;         // (local_conditions, N)
};

template <class Real>
struct ReferenceOutputs {
  std::vector<Real> sigma, red, green, blue;  // (N)
};

template <class Real>
struct ReferenceGradients {
  std::vector<Real> parameters;           // as Field::parameters
  std::vector<Real> conditions, latents;  // as the samples' arrays
  std::vector<Real> x, y, z;              // (N)
};

template <class Real>
ReferenceOutputs<Real> reference_forward(const FieldConfig& config, std::span<const Real> parameters,
                                         const ReferenceSamples<Real>& samples);

// Gradients of the loss whose gradients with respect to the outputs are `output_gradients`.
template <class Real>
ReferenceGradients<Real> reference_backward(const FieldConfig& config, std::span<const Real> parameters,
                                            const ReferenceSamples<Real>& samples,
                                            const ReferenceOutputs<Real>& output_gradients);

// The slice w (N, ambient dimensions) of each sample, each in (-1, 1); empty without an ambient slice.
template <class Real>
std::vector<Real> reference_slice(const FieldConfig& config, std::span<const Real> parameters,
                                  const ReferenceSamples<Real>& samples);

// How far each sample (N) is from the nearest point where the field has no derivative: the smallest |sum|
// that meets a ReLU, and the smallest distance to a cell border, in cells. Gradients of samples whose margin
// is within rounding depend on the order of additions, so comparisons leave them out.
template <class Real>
std::vector<Real> reference_margin(const FieldConfig& config, std::span<const Real> parameters,
                                   const ReferenceSamples<Real>& samples);

// Copies a batch; null directions become (0, 0, 1). `views`: rows of conditions and latents to copy.
template <class Real>
ReferenceSamples<Real> reference_samples(const FieldConfig& config, const FieldInputs& inputs,
                                         std::size_t views);

}  // namespace likeness
