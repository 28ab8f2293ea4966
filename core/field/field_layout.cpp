// Levels and layers, one behind the other: see field_layout.h.
#include "core/field/field_layout.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/check.h"

namespace likeness {
namespace {

void check_grid(const GridConfig& grid, int min_dimensions, const char* name) {
  LIKENESS_CHECK(grid.dimensions >= min_dimensions && grid.dimensions <= 3, "%s grid of %d dimensions", name,
                 grid.dimensions);
  LIKENESS_CHECK(grid.levels >= 1 && grid.levels <= 32, "%s grid of %d levels", name, grid.levels);
  LIKENESS_CHECK(grid.features == 1 || grid.features == 2 || grid.features == 4 || grid.features == 8,
                 "%s grid of %d features a level", name, grid.features);
  LIKENESS_CHECK(grid.log2_entries >= 4 && grid.log2_entries <= 24, "%s grid of 2^%d entries", name,
                 grid.log2_entries);
  LIKENESS_CHECK(
      grid.min_resolution >= 1 && grid.max_resolution >= grid.min_resolution && grid.max_resolution <= 16384,
      "%s grid of %d to %d cells", name, grid.min_resolution, grid.max_resolution);
}

std::vector<GridLevel> grid_levels(const GridConfig& grid, std::size_t& offset) {
  std::vector<GridLevel> levels(grid.levels);
  for (int l = 0; l < grid.levels; ++l) {
    GridLevel& level = levels[l];
    const double share = grid.levels > 1 ? double(l) / (grid.levels - 1) : 0.0;
    const double growth = double(grid.max_resolution) / grid.min_resolution;
    level.resolution = int(std::floor(grid.min_resolution * std::pow(growth, share) + 1e-6));
    const std::size_t capacity = std::size_t{1} << grid.log2_entries;
    std::size_t vertices = 1;
    for (int a = 0; a < grid.dimensions; ++a) {
      level.stride[a] = std::uint32_t(std::min(vertices, capacity));
      vertices *= std::size_t(level.resolution) + 1;
    }
    level.hashed = vertices > capacity;
    level.entries = level.hashed ? capacity : vertices;
    level.mask = level.hashed ? std::uint32_t(capacity - 1) : 0;
    level.offset = offset;
    offset += (level.entries * grid.features + kTableLine - 1) / kTableLine * kTableLine;
  }
  return levels;
}

std::vector<DenseLayer> network(int inputs, int width, int hidden, int outputs, std::size_t& offset) {
  std::vector<DenseLayer> layers;
  for (int l = 0; l <= hidden; ++l) {
    DenseLayer layer{l == 0 ? inputs : width, l == hidden ? outputs : width};
    layer.weights = offset;
    layer.biases = offset + std::size_t(layer.inputs) * layer.outputs;
    offset = layer.biases + layer.outputs;
    layers.push_back(layer);
  }
  return layers;
}

}  // namespace

FieldLayout make_layout(const FieldConfig& config) {
  check_grid(config.position, 3, "position");
  LIKENESS_CHECK(config.condition_count >= 0 && config.condition_count <= 256, "%d conditions",
                 config.condition_count);
  LIKENESS_CHECK(config.local_conditions >= 0 && config.local_conditions <= config.condition_count,
                 "%d of %d conditions act in a region", config.local_conditions, config.condition_count);
  LIKENESS_CHECK(config.latent_count >= 0 && config.latent_count <= 256, "%d latents", config.latent_count);
  LIKENESS_CHECK(config.geometry_features >= 0 && config.geometry_features <= 255, "%d geometry features",
                 config.geometry_features);
  for (int width : {config.slice_width, config.density_width, config.colour_width}) {
    LIKENESS_CHECK(width >= 1 && width <= 512, "network of width %d", width);
  }
  LIKENESS_CHECK(config.density_layers >= 1 && config.density_layers <= 2 && config.colour_layers >= 1 &&
                     config.colour_layers <= 2,
                 "%d and %d hidden layers", config.density_layers, config.colour_layers);
  LIKENESS_CHECK(config.slice_levels >= 1, "a slice of %d levels", config.slice_levels);
  LIKENESS_CHECK(config.initial_density > 0, "initial density %g", double(config.initial_density));

  FieldLayout layout;
  std::size_t offset = 0;
  layout.position = grid_levels(config.position, offset);
  layout.position_features = config.position.levels * config.position.features;
  if (config.ambient && config.condition_count > 0) {
    check_grid(config.ambient_grid, 1, "ambient");
    layout.ambient = grid_levels(config.ambient_grid, offset);
    layout.ambient_dimensions = config.ambient_grid.dimensions;
    layout.ambient_features = config.ambient_grid.levels * config.ambient_grid.features;
  } else {
    layout.concat_count = config.condition_count;
  }
  layout.table_count = offset;
  if (layout.has_ambient()) {
    layout.slice_features = std::min(config.slice_levels, config.position.levels) * config.position.features;
    layout.slice = network(layout.slice_features + config.condition_count, config.slice_width, 1,
                           layout.ambient_dimensions, offset);
  }
  layout.density = network(layout.position_features + layout.ambient_features + layout.concat_count,
                           config.density_width, config.density_layers, 1 + config.geometry_features, offset);
  layout.direction_features = config.view_direction ? kDirectionFeatures : 0;
  const int colour_inputs = config.geometry_features + layout.direction_features + config.latent_count;
  LIKENESS_CHECK(colour_inputs > 0, "the colour network has no input");
  layout.colour = network(colour_inputs, config.colour_width, config.colour_layers, 3, offset);
  layout.parameter_count = offset;
  return layout;
}

}  // namespace likeness
