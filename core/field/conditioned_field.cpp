// Folding psi into biases, and rounding: see conditioned_field.h.
#include "core/field/conditioned_field.h"

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/field/conditioned_parts.h"

namespace likeness {
namespace {

constexpr std::size_t kRoundChunk = 1 << 16;

// Appends the layers to `networks`, the first without its columns from `inputs` on, of which those of psi are
// added to the biases, and makes the layers point there.
void fold(const std::vector<float>& parameters, int inputs, std::span<const float> psi,
          std::vector<DenseLayer>& layers, std::vector<float>& networks) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    DenseLayer& layer = layers[l];
    const std::size_t old = std::size_t(layer.inputs), kept = l == 0 ? std::size_t(inputs) : old;
    const std::size_t weights = networks.size();
    std::vector<float> biases;
    for (std::size_t o = 0; o < std::size_t(layer.outputs); ++o) {
      const float* row = parameters.data() + layer.weights + o * old;
      networks.insert(networks.end(), row, row + kept);
      double bias = parameters[layer.biases + o];
      if (l == 0)
        for (std::size_t k = 0; k < psi.size(); ++k) bias += double(row[kept + k]) * double(psi[k]);
      biases.push_back(float(bias));
    }
    layer.inputs = int(kept), layer.weights = weights, layer.biases = networks.size();
    networks.insert(networks.end(), biases.begin(), biases.end());
  }
}

std::shared_ptr<const RoundedTables> rounded_tables(const Field& field, std::size_t count) {
  auto tables = std::make_shared<RoundedTables>();
  tables->count = count;
  tables->memory.reserve((count + 1) / 2);
  parallel_ranges(count, kRoundChunk, [&](std::size_t begin, std::size_t end) {
    round_table(field.parameters.data() + begin, end - begin, tables->values() + begin);
  });
  return tables;
}

}  // namespace

bool has_bf16(const FieldConfig& config) {
  const bool ambient = config.ambient && config.condition_count > 0;
  return cpu_has_bf16() && grid_has_bf16(config.position) && (!ambient || grid_has_bf16(config.ambient_grid));
}

void round_tables(Field& field) {
  if (has_bf16(field.config)) field.rounded = rounded_tables(field, make_layout(field.config).table_count);
}

ConditionedField::ConditionedField(const Field& field, std::span<const float> psi, FieldPrecision precision)
    : parts_(std::make_unique<ConditionedParts>()) {
  ConditionedParts& p = *parts_;
  p.config = field.config;
  p.layout = make_layout(field.config);
  LIKENESS_CHECK(field.parameters.size() == p.layout.parameter_count &&
                     psi.size() == std::size_t(field.config.condition_count),
                 "%zu parameters and %zu conditions for a field of %zu and %d", field.parameters.size(),
                 psi.size(), p.layout.parameter_count, field.config.condition_count);
  p.config.condition_count = p.config.latent_count = 0;
  p.tables = field.parameters.data();
  const int e = p.layout.position_features, a = p.layout.ambient_features;
  const bool ambient = p.layout.has_ambient();
  if (ambient) fold(field.parameters, p.layout.slice_features, psi, p.layout.slice, p.networks);
  fold(field.parameters, e + a, ambient ? std::span<const float>{} : psi, p.layout.density, p.networks);
  fold(field.parameters, p.config.geometry_features + p.layout.direction_features, {}, p.layout.colour,
       p.networks);
  p.layout.concat_count = 0;
  if (precision == FieldPrecision::exact || !has_bf16(field.config)) return;
  p.rounded = field.rounded ? field.rounded : rounded_tables(field, p.layout.table_count);
  LIKENESS_CHECK(p.rounded->count == p.layout.table_count, "%zu rounded entries for tables of %zu",
                 p.rounded->count, p.layout.table_count);
  p.bf16 = Bf16Parts{p.rounded->values(), pack_network(p.layout.density, p.networks.data()),
                     pack_network(p.layout.colour, p.networks.data())};
}

ConditionedField::~ConditionedField() = default;
ConditionedField::ConditionedField(ConditionedField&&) noexcept = default;
ConditionedField& ConditionedField::operator=(ConditionedField&&) noexcept = default;

}  // namespace likeness
