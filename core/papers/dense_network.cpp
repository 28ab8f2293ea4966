// Forward and backward passes of dense networks.
#include "core/papers/dense_network.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/papers/dense_product.h"
#include "core/train/random_stream.h"

namespace likeness {
namespace {

std::size_t layer_count(const DenseNetworkSpec& spec, const DenseLayerSpec& layer) {
  std::size_t count = std::size_t(layer.outputs);
  for (const int source : layer.sources) count += std::size_t(layer.outputs) * spec.node_rows(source);
  return count;
}

}  // namespace

std::size_t parameter_count(const DenseNetworkSpec& spec) {
  std::size_t count = 0;
  for (const DenseLayerSpec& layer : spec.layers) count += layer_count(spec, layer);
  return count;
}

void initialise(const DenseNetworkSpec& spec, std::uint64_t seed, std::span<float> parameters) {
  LIKENESS_CHECK(parameters.size() == parameter_count(spec), "%zu parameters for a network of %zu",
                 parameters.size(), parameter_count(spec));
  std::size_t at = 0;
  for (const DenseLayerSpec& layer : spec.layers) {
    const std::size_t weights = layer_count(spec, layer) - std::size_t(layer.outputs);
    const float bound = std::sqrt((layer.activation == Activation::relu ? 6.f : 3.f) * float(layer.outputs) /
                                  float(std::max<std::size_t>(weights, 1)));
    RandomStream random(seed, 0x6e657266, at);
    for (std::size_t i = 0; i < weights; ++i) parameters[at++] = bound * (2 * random.uniform() - 1);
    for (int i = 0; i < layer.outputs; ++i) parameters[at++] = 0;
  }
}

template <class Real>
void network_forward(const DenseNetworkSpec& spec, const Real* parameters, DenseNodes<Real>& nodes) {
  const std::size_t given = spec.inputs.size();
  nodes.resize(given + spec.layers.size());
  const auto n = nodes.front().cols();
  const DenseProducts<Real>& product = dense_products<Real>();
  for (std::size_t l = 0; l < spec.layers.size(); ++l) {
    const DenseLayerSpec& layer = spec.layers[l];
    const Real* weights = parameters;
    parameters += layer_count(spec, layer);
    DenseMatrix<Real>& out = nodes[given + l];
    const Eigen::Map<const Eigen::Vector<Real, Eigen::Dynamic>> bias(parameters - layer.outputs,
                                                                     layer.outputs);
    out = bias.replicate(1, n);
    for (const int source : layer.sources) {
      const int rows = spec.node_rows(source);
      if (rows == 0) continue;
      product.add_forward(weights, layer.outputs, rows, nodes[std::size_t(source)].data(), int(n),
                          out.data());
      weights += std::ptrdiff_t(rows) * layer.outputs;
    }
    if (layer.activation == Activation::relu) out = out.cwiseMax(Real(0));
  }
}

template <class Real>
void network_backward(const DenseNetworkSpec& spec, const Real* parameters, const DenseNodes<Real>& nodes,
                      std::span<const int> wanted_inputs, DenseNodes<Real>& slopes,
                      Real* parameter_gradients) {
  const std::size_t given = spec.inputs.size();
  slopes.resize(nodes.size());
  const auto n = nodes.front().cols();
  const DenseProducts<Real>& product = dense_products<Real>();
  std::size_t end = parameter_count(spec);
  for (std::size_t l = spec.layers.size(); l-- > 0;) {
    const DenseLayerSpec& layer = spec.layers[l];
    end -= layer_count(spec, layer);
    DenseMatrix<Real>& slope = slopes[given + l];
    if (slope.size() == 0) continue;  // nothing depends on it
    if (layer.activation == Activation::relu)
      slope = (nodes[given + l].array() > Real(0)).select(slope, Real(0));
    std::size_t at = end;
    for (const int source : layer.sources) {
      const int rows = spec.node_rows(source);
      if (rows == 0) continue;
      const auto s = std::size_t(source);
      product.add_weights(slope.data(), layer.outputs, rows, nodes[s].data(), int(n),
                          parameter_gradients + at);
      if (s >= given || std::ranges::find(wanted_inputs, source) != wanted_inputs.end()) {
        if (slopes[s].size() == 0) slopes[s].setZero(rows, n);
        product.add_backward(parameters + at, layer.outputs, rows, slope.data(), int(n), slopes[s].data());
      }
      at += std::size_t(rows) * std::size_t(layer.outputs);
    }
    Eigen::Map<Eigen::Vector<Real, Eigen::Dynamic>>(parameter_gradients + at, layer.outputs) +=
        slope.rowwise().sum();
  }
}

template void network_forward(const DenseNetworkSpec&, const float*, DenseNodes<float>&);
template void network_forward(const DenseNetworkSpec&, const double*, DenseNodes<double>&);
template void network_backward(const DenseNetworkSpec&, const float*, const DenseNodes<float>&,
                               std::span<const int>, DenseNodes<float>&, float*);
template void network_backward(const DenseNetworkSpec&, const double*, const DenseNodes<double>&,
                               std::span<const int>, DenseNodes<double>&, double*);

}  // namespace likeness
