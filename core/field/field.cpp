// Blocks and initial values of a field's parameters: see field.h.
#include "core/field/field.h"

#include <cmath>
#include <random>

#include "core/field/field_layout.h"
#include "core/field/huge_pages.h"

namespace likeness {
namespace {

void add_table_blocks(const std::vector<GridLevel>& levels, int features, const std::string& name,
                      std::vector<ParameterBlock>& blocks) {
  for (std::size_t l = 0; l < levels.size(); ++l) {
    blocks.push_back(
        {name + ".level" + std::to_string(l), levels[l].offset, levels[l].entries * features, 0, 0, true});
  }
}

void add_network_blocks(const std::vector<DenseLayer>& layers, const std::string& name,
                        std::vector<ParameterBlock>& blocks) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const DenseLayer& layer = layers[l];
    const std::string suffix = std::to_string(l);
    blocks.push_back({name + ".weights" + suffix, layer.weights, std::size_t(layer.inputs) * layer.outputs,
                      layer.outputs, layer.inputs, false});
    blocks.push_back({name + ".biases" + suffix, layer.biases, std::size_t(layer.outputs), 0, 0, false});
  }
}

// The standard library's distributions differ between implementations; this one does not.
struct Random {
  std::mt19937 engine;
  float uniform(float low, float high) { return low + (high - low) * (float(engine() >> 8) * 0x1p-24f); }
};

// Hidden layers: He et al. 2015 (ReLU). The linear output layer: Glorot & Bengio 2010. Uniform both.
void fill_network(const std::vector<DenseLayer>& layers, Random& random, std::vector<float>& parameters) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const DenseLayer& layer = layers[l];
    const bool output = l + 1 == layers.size();
    const float bound = std::sqrt(6.0f / float(output ? layer.inputs + layer.outputs : layer.inputs));
    for (std::size_t i = 0; i < std::size_t(layer.inputs) * layer.outputs; ++i) {
      parameters[layer.weights + i] = random.uniform(-bound, bound);
    }
  }
}

}  // namespace

std::vector<ParameterBlock> parameter_layout(const FieldConfig& config) {
  const FieldLayout layout = make_layout(config);
  std::vector<ParameterBlock> blocks;
  add_table_blocks(layout.position, config.position.features, "position", blocks);
  add_table_blocks(layout.ambient, config.ambient_grid.features, "ambient", blocks);
  add_network_blocks(layout.slice, "slice", blocks);
  add_network_blocks(layout.density, "density", blocks);
  add_network_blocks(layout.colour, "colour", blocks);
  return blocks;
}

std::size_t parameter_count(const FieldConfig& config) { return make_layout(config).parameter_count; }

Field make_field(const FieldConfig& config, std::uint32_t seed) {
  const FieldLayout layout = make_layout(config);
  Field field{config, large_array(layout.parameter_count)};
  Random random{std::mt19937(seed)};
  for (const ParameterBlock& block : parameter_layout(config)) {
    if (!block.table) continue;
    for (std::size_t i = 0; i < block.count; ++i) {
      field.parameters[block.offset + i] = random.uniform(-1e-4f, 1e-4f);
    }
  }
  fill_network(layout.slice, random, field.parameters);
  fill_network(layout.density, random, field.parameters);
  fill_network(layout.colour, random, field.parameters);
  field.parameters[layout.density.back().biases] = std::log(config.initial_density);
  return field;
}

}  // namespace likeness
