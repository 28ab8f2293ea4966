// Where the field's tables and weights lie, resolved once for the kernels. Internal to core/field.
#pragma once

#include <cstddef>
#include <vector>

#include "core/field/field_config.h"
#include "core/field/field_levels.h"

namespace likeness {

struct FieldLayout {
  std::vector<GridLevel> position, ambient;          // ambient empty without a slice
  std::vector<DenseLayer> slice, density, colour;    // hidden layers (ReLU), then the linear output layer
  std::size_t table_count = 0, parameter_count = 0;  // tables are [0, table_count), a multiple of kTableLine
  int position_features = 0;                         // of e
  int slice_features = 0;                            // of e, the first, the inputs of H
  int ambient_dimensions = 0, ambient_features = 0;  // of w, a
  int concat_count = 0;                              // entries of psi appended to the density input
  int direction_features = 0;

  bool has_ambient() const { return !ambient.empty(); }
};

// Levels of the position grid, the coarsest, that training reads in single precision, since they are inputs
// of H: rounding e would move w by a tenth of a fine ambient cell, and perturb derivatives with respect to w.
inline std::size_t exact_levels(const FieldConfig& config, const FieldLayout& layout) {
  return layout.has_ambient() ? std::size_t(layout.slice_features / config.position.features) : 0;
}

// Checks the configuration; a configuration out of range is a programmer's mistake.
FieldLayout make_layout(const FieldConfig& config);

}  // namespace likeness
