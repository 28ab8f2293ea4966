// The kernels of field_bf16.h in plain loops: rounding happens at the same places.
#include "core/field/field_bf16.h"

#include <algorithm>
#include <vector>

#include "core/field/field_kernels.h"

namespace likeness {
namespace {

float rounded(float value) { return from_bf16(to_bf16(value)); }

float weight_of(const PackedLayer& layer, std::size_t output, std::size_t input) {
  const std::size_t pairs = (std::size_t(layer.inputs) + 1) / 2;
  const std::uint32_t word = layer.weights[(output / 8 * pairs + input / 2) * 8 + output % 8];
  return from_bf16(std::uint16_t(input % 2 == 0 ? word : word >> 16));
}

}  // namespace

void encode_tile_bf16_reference(const GridLevel& level, const GridConfig& grid, const std::uint16_t* tables,
                                const float* const* point, float* rows) {
  const auto width = std::size_t(grid.features);
  std::fill(rows, rows + width * kTile, 0.0f);
  for (std::size_t s = 0; s < kTile; ++s)
    for (int corner = 0; corner < 1 << grid.dimensions; ++corner) {
      float weight = 1;
      std::uint32_t entry = 0;
      for (int a = 0; a < grid.dimensions; ++a) {
        const float p = std::clamp(point[a][s], 0.0f, 1.0f) * float(level.resolution);
        const int cell = std::min(int(p), level.resolution - 1), side = corner >> a & 1;
        const float part = p - float(cell);
        weight *= side ? part : 1 - part;
        const std::uint32_t vertex = std::uint32_t(cell + side);
        entry = level.hashed ? entry ^ vertex * kHashPrime[a] : entry + vertex * level.stride[a];
      }
      if (level.hashed) entry &= level.mask;
      for (std::size_t f = 0; f < width; ++f)
        rows[f * kTile + s] += rounded(weight) * from_bf16(tables[level.offset + entry * width + f]);
    }
}

void network_bf16_reference(const PackedNetwork& network, const float* in, std::size_t outputs, float* out) {
  std::vector<float> below(in, in + std::size_t(network.front().inputs) * kTile);
  for (std::size_t l = 0; l < network.size(); ++l) {
    const PackedLayer& layer = network[l];
    const bool last = l + 1 == network.size();
    const std::size_t count = last ? outputs : std::size_t(layer.outputs);
    std::vector<float> above(count * kTile);
    for (std::size_t o = 0; o < count; ++o)
      for (std::size_t s = 0; s < kTile; ++s) {
        float sum = layer.biases[o];
        for (std::size_t i = 0; i < std::size_t(layer.inputs); ++i)
          sum += weight_of(layer, o, i) * rounded(below[i * kTile + s]);
        above[o * kTile + s] = last ? sum : std::max(sum, 0.0f);
      }
    below = std::move(above);
  }
  std::copy(below.begin(), below.end(), out);
}

PlainGradients network_backward_bf16_reference(const PackedNetwork& network, const float* in,
                                               const float* g) {
  // Inputs of every layer, rounded.
  std::vector<std::vector<float>> seen;
  for (std::size_t l = 0; l < network.size(); ++l) {
    const PackedNetwork below(network.begin(), network.begin() + std::ptrdiff_t(l));
    std::vector<float> x(std::size_t(network[l].inputs) * kTile);
    if (l == 0)
      std::copy(in, in + x.size(), x.begin());
    else
      network_bf16_reference(below, in, std::size_t(network[l].inputs), x.data());
    for (float& v : x) v = rounded(l == 0 ? v : std::max(v, 0.0f));
    seen.push_back(std::move(x));
  }
  PlainGradients out;
  out.weights.resize(network.size()), out.biases.resize(network.size());
  std::vector<float> slopes(g, g + std::size_t(network.back().outputs) * kTile);
  for (std::size_t l = network.size(); l-- > 0;) {
    const std::size_t inputs = std::size_t(network[l].inputs), outputs = std::size_t(network[l].outputs);
    const std::vector<float>& x = seen[l];
    out.weights[l].assign(outputs * inputs, 0.0f), out.biases[l].assign(outputs, 0.0f);
    std::vector<float> below(inputs * kTile, 0.0f);
    for (std::size_t o = 0; o < outputs; ++o)
      for (std::size_t s = 0; s < kTile; ++s) {
        const float slope = slopes[o * kTile + s];
        out.biases[l][o] += slope;
        for (std::size_t i = 0; i < inputs; ++i) {
          out.weights[l][o * inputs + i] += rounded(slope) * x[i * kTile + s];
          if (l == 0 || x[i * kTile + s] > 0)
            below[i * kTile + s] += rounded(slope) * weight_of(network[l], o, i);
        }
      }
    slopes = std::move(below);
  }
  out.inputs = std::move(slopes);
  return out;
}

}  // namespace likeness
