// Where the field's tables and weights lie, resolved once for the kernels. Internal to core/field.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/field/field.h"

namespace likeness {

// One level of a grid. `resolution` cells along an axis, resolution + 1 vertices. A level whose vertices fit
// the table is dense (x fastest), otherwise a vertex's entry is its spatial hash.
struct GridLevel {
  int resolution = 0;
  bool hashed = false;
  std::uint32_t mask = 0;     // entries - 1 when hashed
  std::uint32_t stride[3]{};  // of a dense level, entries
  std::size_t offset = 0;     // of the first parameter
  std::size_t entries = 0;
};

// out = W in + b, W row-major (outputs, inputs).
struct DenseLayer {
  int inputs = 0, outputs = 0;
  std::size_t weights = 0, biases = 0;  // offsets into the parameters
};

struct FieldLayout {
  std::vector<GridLevel> position, ambient;          // ambient empty without a slice
  std::vector<DenseLayer> slice, density, colour;    // hidden layers (ReLU), then the linear output layer
  std::size_t table_count = 0, parameter_count = 0;  // tables are [0, table_count), a multiple of kTableLine
  int position_features = 0;                         // of e
  int ambient_dimensions = 0, ambient_features = 0;  // of w, a
  int concat_count = 0;                              // entries of psi appended to the density input
  int direction_features = 0;

  bool has_ambient() const { return !ambient.empty(); }
};

// Checks the configuration; a configuration out of range is a programmer's mistake.
FieldLayout make_layout(const FieldConfig& config);

// Primes of the spatial hash of Teschner et al. 2003 as used by Mueller et al. 2022; 1 keeps neighbours in x
// in one cache line.
inline constexpr std::uint32_t kHashPrime[3] = {1u, 2654435761u, 805459861u};

// Density: exp(r) to r = kDensityKnee, then its tangent.
inline constexpr float kDensityKnee = 9.0f;

// Real spherical harmonics of degree <= 2 have 9 functions; these are the constants of the polynomials.
inline constexpr int kDirectionFeatures = 9;
inline constexpr double kHarmonic0 = 0.28209479177387814;   // sqrt(1 / (4 pi))
inline constexpr double kHarmonic1 = 0.4886025119029199;    // sqrt(3 / (4 pi))
inline constexpr double kHarmonic2 = 1.0925484305920792;    // sqrt(15 / (4 pi))
inline constexpr double kHarmonic2z = 0.31539156525252005;  // sqrt(5 / (16 pi))
inline constexpr double kHarmonic2xy = 0.5462742152960396;  // sqrt(15 / (16 pi))

}  // namespace likeness
