// Rounding and packing for the kernels in bfloat16: see field_bf16.h.
#include "core/field/field_bf16.h"

#include <bit>

#include "core/field/bf16_intrinsics.h"

namespace likeness {

std::uint16_t to_bf16(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  if ((bits & 0x7fffffffu) > 0x7f800000u) return std::uint16_t(bits >> 16 | 0x40u);  // not a number
  return std::uint16_t((bits + 0x7fffu + (bits >> 16 & 1u)) >> 16);
}

float from_bf16(std::uint16_t value) { return std::bit_cast<float>(std::uint32_t(value) << 16); }

namespace {

// weight(output, input) of the layer.
template <class Weight>
PackedLayer pack(int inputs, int outputs, const Weight& weight) {
  PackedLayer packed{inputs, outputs, {}, std::vector<float>(std::size_t(outputs), 0.0f)};
  packed.weights.reserve(std::size_t((outputs + 7) / 8 * 8) * std::size_t((inputs + 1) / 2));
  const auto at = [&](int output, int input) {
    return output < outputs && input < inputs ? std::uint32_t(to_bf16(weight(output, input))) : 0u;
  };
  for (int block = 0; block < outputs; block += 8)
    for (int input = 0; input < inputs; input += 2)
      for (int o = block; o < block + 8; ++o) packed.weights.push_back(at(o, input) | at(o, input + 1) << 16);
  return packed;
}

}  // namespace

PackedNetwork pack_network(const std::vector<DenseLayer>& layers, const float* parameters) {
  PackedNetwork network;
  for (const DenseLayer& layer : layers) {
    network.push_back(pack(layer.inputs, layer.outputs, [&](int output, int input) {
      return parameters[layer.weights + std::size_t(output) * std::size_t(layer.inputs) + std::size_t(input)];
    }));
    network.back().biases.assign(parameters + layer.biases, parameters + layer.biases + layer.outputs);
  }
  return network;
}

PackedLayer pack_transposed(const DenseLayer& layer, const float* parameters, int first, int count) {
  return pack(layer.outputs, count, [&](int column, int row) {
    return parameters[layer.weights + std::size_t(row) * std::size_t(layer.inputs) +
                      std::size_t(first + column)];
  });
}

PackedNetwork pack_transposed(const std::vector<DenseLayer>& layers, const float* parameters) {
  PackedNetwork network;
  for (const DenseLayer& layer : layers)
    network.push_back(network.empty() ? PackedLayer{layer.outputs, layer.inputs, {}, {}}
                                      : pack_transposed(layer, parameters, 0, layer.inputs));
  return network;
}

PackedSlopes pack_slopes(const FieldConfig& config, const FieldLayout& layout, const float* parameters) {
  const DenseLayer &density = layout.density.front(), &colour = layout.colour.front();
  const int e = layout.position_features, g = config.geometry_features;
  return {pack_transposed(layout.density, parameters),
          pack_transposed(layout.colour, parameters),
          pack_transposed(density, parameters, 0, e),
          pack_transposed(density, parameters, e, density.inputs - e),
          pack_transposed(colour, parameters, 0, g),
          pack_transposed(colour, parameters, g + layout.direction_features, config.latent_count)};
}

bool grid_has_bf16(const GridConfig& grid) {
  return grid.features == 2 || grid.features == 4 || grid.features == 8;
}

bool cpu_has_bf16() {
#ifdef LIKENESS_BF16_KERNELS
  static const bool has = __builtin_cpu_supports("avx512bf16") && __builtin_cpu_supports("avx512bw") &&
                          __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
                          __builtin_cpu_supports("fma");
  return has;
#else
  return false;
#endif
}

}  // namespace likeness
