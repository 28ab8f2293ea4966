// Counting a field's work: see field_work.h.
#include "core/lab/bench/field_work.h"

#include "core/field/field_layout.h"

namespace likeness {
namespace {

// Only the first `inputs` inputs of the first layer count; `slopes` of them need a gradient.
void add_network(const std::vector<DenseLayer>& layers, int inputs, int slopes, bool dots, FieldWork& work) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const double outputs = layers[l].outputs;
    const double in = l == 0 ? inputs : layers[l].inputs, back = l == 0 ? slopes : layers[l].inputs;
    const double forward = 2 * outputs * in, training = 2 * outputs * (2 * in + back);
    work.forward_flops += forward, work.training_flops += training;
    if (dots) work.forward_dots += forward, work.training_dots += training;
  }
}

void add_tables(const std::vector<GridLevel>& levels, const GridConfig& grid, bool point_gradient,
                std::size_t exact, FieldWork& work) {
  const double corners = double(std::size_t{1} << grid.dimensions);
  for (std::size_t l = 0; l < levels.size(); ++l)
    work.tables.push_back({levels[l].entries * std::size_t(grid.features) * sizeof(float), corners,
                           (point_gradient ? 2 : 1) * corners, corners, l >= exact});
}

// Seconds of a table read in the forward pass.
double feature_seconds(const TableWork& table, const Ceilings& ceilings, bool bf16) {
  return gather_seconds(ceilings, bf16 && table.halved ? table.bytes / 2 : table.bytes);
}

double operation_seconds(double all, double dots, const Ceilings& ceilings, bool bf16) {
  if (!bf16) return all / (1e9 * ceilings.fma_gflops);
  return (all - dots) / (1e9 * ceilings.fma_gflops) + dots / (1e9 * ceilings.bf16_gflops);
}

}  // namespace

FieldWork field_work(const FieldConfig& config) {
  const FieldLayout layout = make_layout(config);
  FieldWork work;
  add_tables(layout.position, config.position, false, exact_levels(config, layout), work);
  if (layout.has_ambient()) {
    add_tables(layout.ambient, config.ambient_grid, true, 0, work);
    add_network(layout.slice, layout.slice_features, layout.slice_features, false, work);
  }
  const int features = layout.position_features + layout.ambient_features;
  add_network(layout.density, features, features, true, work);
  add_network(layout.colour, config.geometry_features + layout.direction_features + config.latent_count,
              config.geometry_features + config.latent_count, true, work);
  return work;
}

double forward_floor_seconds(const FieldWork& work, const Ceilings& ceilings, FieldPrecision precision) {
  const bool bf16 = precision == FieldPrecision::bf16;
  double seconds = operation_seconds(work.forward_flops, work.forward_dots, ceilings, bf16);
  for (const TableWork& table : work.tables)
    seconds += table.forward_reads * feature_seconds(table, ceilings, bf16);
  return seconds;
}

double training_floor_seconds(const FieldWork& work, const Ceilings& ceilings, FieldPrecision precision) {
  const bool bf16 = precision == FieldPrecision::bf16;
  double seconds = operation_seconds(work.training_flops, work.training_dots, ceilings, bf16);
  for (const TableWork& table : work.tables)
    seconds += table.forward_reads * feature_seconds(table, ceilings, bf16) +
               (table.training_reads - table.forward_reads) * gather_seconds(ceilings, table.bytes) +
               table.updates * read_modify_write_seconds(ceilings, table.bytes);
  return seconds;
}

}  // namespace likeness
