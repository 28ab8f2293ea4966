// The radiance field of one rigid frame (head or torso): spatial hash grid -> ambient slice w = H(features,
// psi) -> ambient grid -> density MLP -> colour MLP. Kwak & Ko, IEEE Access 2024, sections III-B, III-C; hash
// encoding after Mueller et al. 2022.
//
//   e = G(x)                      (levels x features)
//   w = tanh(H(e_coarse, psi))    (ambient_dimensions), fp32; e_coarse: e of the coarsest slice_levels
//   a = A(w)                      (ambient levels x features)
//   sigma, g = D(e, a)            density (exp up to e^9, then its tangent) and geometry features
//   c = sigmoid(C(g, d, l))       colour; d the view direction, l the per-frame latent code
//
// The exponential gives a density of any scale the same relative learning rate; softplus, linear where it is
// large, needs many steps to become a surface. The tangent beyond e^9 keeps value and gradient finite and
// consistent.
//
// Arrays of samples are one array per component ("samples in lanes").
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/field/field_config.h"
#include "core/field/field_levels.h"  // kTableLine

namespace likeness {

struct RoundedTables;  // in bfloat16, see precision.h

struct Field {
  FieldConfig config;
  std::vector<float> parameters;  // all tables and weights; see parameter_layout()
  // For a field that no longer changes, or null: then every picture rounds them again.
  std::shared_ptr<const RoundedTables> rounded = nullptr;
};

// Where each part of the parameters lies, in order: name, offset, count, (rows, columns) for weights.
struct ParameterBlock {
  std::string name;
  std::size_t offset = 0, count = 0;
  int rows = 0, columns = 0;  // weights are row-major (outputs, inputs); 0 for tables and biases
  bool table = false;         // hash table: sparse gradient
};
// Tables come first, each starting at a multiple of kTableLine parameters (zeros fill the gaps), then the
// networks.
std::vector<ParameterBlock> parameter_layout(const FieldConfig& config);
std::size_t parameter_count(const FieldConfig& config);
Field make_field(const FieldConfig& config, std::uint32_t seed);

struct FieldInputs {
  std::size_t count = 0;                                    // N
  const float *x = nullptr, *y = nullptr, *z = nullptr;     // (N) in [0, 1] of the field's cube
  const float *dx = nullptr, *dy = nullptr, *dz = nullptr;  // (N) unit view direction in the field's frame
  const std::int32_t* view = nullptr;                       // (N) row of the two arrays below; nullptr: row 0
  const float* conditions = nullptr;                        // (views, K) psi
  const float* latents = nullptr;                           // (views, L), or nullptr for zero codes
  const float* local = nullptr;  // (local_conditions, N) weights of the last entries of psi, 0..1
};

struct FieldOutputs {
  std::vector<float> sigma;             // (N) density per unit of the field's cube side, >= 0
  std::vector<float> red, green, blue;  // (N) in [0, 1], sRGB-encoded
};

// Gradients of a scalar loss with respect to the outputs, same shapes.
struct FieldOutputGradients {
  const float *sigma = nullptr, *red = nullptr, *green = nullptr, *blue = nullptr;  // (N)
};

}  // namespace likeness
