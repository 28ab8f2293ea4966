// Folding psi into biases, and rounding: see conditioned_field.h.
#include "core/field/conditioned_field.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/field/conditioned_parts.h"
#include "core/field/rounded_tables.h"

namespace likeness {
namespace {

// Appends the layers to `networks`, the first without its columns from `inputs` on, of which those of psi are
// added to the biases and the next `local` are kept, and makes the layers point there.
void fold(const std::vector<float>& parameters, int inputs, std::span<const float> psi, std::size_t local,
          std::vector<DenseLayer>& layers, std::vector<float>& networks) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    DenseLayer& layer = layers[l];
    const std::size_t old = std::size_t(layer.inputs), kept = l == 0 ? std::size_t(inputs) : old;
    const std::size_t weights = networks.size();
    std::vector<float> biases;
    for (std::size_t o = 0; o < std::size_t(layer.outputs); ++o) {
      const float* row = parameters.data() + layer.weights + o * old;
      networks.insert(networks.end(), row, row + kept);
      if (l == 0) networks.insert(networks.end(), row + kept + psi.size(), row + kept + psi.size() + local);
      double bias = parameters[layer.biases + o];
      if (l == 0)
        for (std::size_t k = 0; k < psi.size(); ++k) bias += double(row[kept + k]) * double(psi[k]);
      biases.push_back(float(bias));
    }
    layer.inputs = int(l == 0 ? kept + local : kept), layer.weights = weights, layer.biases = networks.size();
    networks.insert(networks.end(), biases.begin(), biases.end());
  }
}

}  // namespace

ConditionedField::ConditionedField(const Field& field, std::span<const float> psi, FieldPrecision precision)
    : parts_(std::make_unique<ConditionedParts>()) {
  ConditionedParts& p = *parts_;
  p.config = field.config;
  p.layout = make_layout(field.config);
  LIKENESS_CHECK(field.parameters.size() == p.layout.parameter_count &&
                     psi.size() == std::size_t(field.config.condition_count),
                 "%zu parameters and %zu conditions for a field of %zu and %d", field.parameters.size(),
                 psi.size(), p.layout.parameter_count, field.config.condition_count);
  const std::span<const float> of_region = psi.last(std::size_t(field.config.local_conditions));
  psi = psi.first(psi.size() - of_region.size());
  if (std::ranges::any_of(of_region, [](float amount) { return amount != 0; }))
    p.local.assign(of_region.begin(), of_region.end());
  const std::size_t local = p.local.size();
  p.config.condition_count = p.config.local_conditions = int(local);
  p.config.latent_count = 0;
  p.tables = field.parameters.data();
  const int e = p.layout.position_features, a = p.layout.ambient_features;
  const bool ambient = p.layout.has_ambient();
  if (ambient) fold(field.parameters, p.layout.slice_features, psi, local, p.layout.slice, p.networks);
  fold(field.parameters, e + a, ambient ? std::span<const float>{} : psi, ambient ? 0 : local,
       p.layout.density, p.networks);
  fold(field.parameters, p.config.geometry_features + p.layout.direction_features, {}, 0, p.layout.colour,
       p.networks);
  p.layout.concat_count = ambient ? 0 : int(local);
  if (precision == FieldPrecision::exact || !has_bf16(field.config)) return;
  p.rounded = tables_of(field, p.layout.table_count);
  p.bf16 = Bf16Parts{p.rounded->values(),
                     0,
                     pack_network(p.layout.density, p.networks.data()),
                     pack_network(p.layout.colour, p.networks.data()),
                     {}};
}

bool ConditionedField::needs_local() const { return !parts_->local.empty(); }

ConditionedField::~ConditionedField() = default;
ConditionedField::ConditionedField(ConditionedField&&) noexcept = default;
ConditionedField& ConditionedField::operator=(ConditionedField&&) noexcept = default;

}  // namespace likeness
