// The sizes of a field's grids and networks, and what its networks are given (field.h).
#pragma once

namespace likeness {

struct GridConfig {
  int dimensions = 3;
  int levels = 8;
  int features = 4;       // per level: 1, 2, 4 or 8; all but 1 are fast (whole entries in one load)
  int log2_entries = 16;  // per level, at most; dense where the level is smaller
  int min_resolution = 16, max_resolution = 512;  // cells along an axis, growing geometrically

  bool operator==(const GridConfig&) const = default;
};

struct FieldConfig {
  GridConfig position;                          // over the field's unit cube
  int condition_count = 0;                      // K: entries of psi; 0 = no ambient slice
  bool ambient = true;                          // false with K > 0: psi is concatenated (NeRFace-like)
  GridConfig ambient_grid{2, 8, 4, 14, 8, 64};  // its dimensions are those of w
  int slice_width = 32;                         // hidden units of H
  int slice_levels = 4;  // of the position grid, the coarsest, that H sees: all, if it has no more. Finer
                         // ones let w jump from point to point, at the cost of unseen expressions
  int density_width = 64, density_layers = 2;  // hidden layers: 1 or 2
  int geometry_features = 15;
  int colour_width = 64, colour_layers = 2;  // hidden layers: 1 or 2
  bool view_direction = true;                // 2nd-order spherical harmonics of d
  int latent_count = 0;                      // L: entries of the per-frame code l
  float initial_density = 0.1f;              // sigma of a fresh field, per cube side
  // This many last entries of psi act only in a region: a sample's are multiplied by FieldInputs::local.
  int local_conditions = 0;

  bool operator==(const FieldConfig&) const = default;
};

}  // namespace likeness
