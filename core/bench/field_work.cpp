// Counting a field's work: see field_work.h.
#include "core/bench/field_work.h"

#include "core/field/field_layout.h"

namespace likeness {
namespace {

// `inputs` of the first layer count, of which `slopes` need a gradient.
void add_network(const std::vector<DenseLayer>& layers, int inputs, int slopes, FieldWork& work) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const double outputs = layers[l].outputs;
    const double in = l == 0 ? inputs : layers[l].inputs, back = l == 0 ? slopes : layers[l].inputs;
    work.forward_flops += 2 * outputs * in;
    work.training_flops += 2 * outputs * (2 * in + back);
  }
}

void add_tables(const std::vector<GridLevel>& levels, const GridConfig& grid, bool point_gradient,
                FieldWork& work) {
  const double corners = double(std::size_t{1} << grid.dimensions);
  for (const GridLevel& level : levels)
    work.tables.push_back({level.entries * std::size_t(grid.features) * sizeof(float), corners,
                           (point_gradient ? 2 : 1) * corners, corners});
}

}  // namespace

FieldWork field_work(const FieldConfig& config) {
  const FieldLayout layout = make_layout(config);
  FieldWork work;
  add_tables(layout.position, config.position, false, work);
  if (layout.has_ambient()) {
    add_tables(layout.ambient, config.ambient_grid, true, work);
    add_network(layout.slice, layout.slice_features, layout.slice_features, work);
  }
  const int features = layout.position_features + layout.ambient_features;
  add_network(layout.density, features, features, work);
  add_network(layout.colour, config.geometry_features + layout.direction_features + config.latent_count,
              config.geometry_features + config.latent_count, work);
  return work;
}

double forward_floor_seconds(const FieldWork& work, const Ceilings& ceilings) {
  double seconds = work.forward_flops / (1e9 * ceilings.fma_gflops);
  for (const TableWork& table : work.tables)
    seconds += table.forward_reads * gather_seconds(ceilings, table.bytes);
  return seconds;
}

double training_floor_seconds(const FieldWork& work, const Ceilings& ceilings) {
  double seconds = work.training_flops / (1e9 * ceilings.fma_gflops);
  for (const TableWork& table : work.tables)
    seconds += table.training_reads * gather_seconds(ceilings, table.bytes) +
               table.updates * read_modify_write_seconds(ceilings, table.bytes);
  return seconds;
}

}  // namespace likeness
