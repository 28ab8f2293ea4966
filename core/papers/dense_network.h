// A feed-forward network of dense layers, any of which may read several earlier outputs and inputs: the skip
// connections and side inputs of the papers' networks, without a copy to concatenate them.
//
//   node i < inputs.size():  given, (rows, N)
//   every further node:      activation(sum over sources W_s node_s + b), (outputs, N)
//
// Column-major: a sample is a column. In float or double.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace likeness {

enum class Activation { none, relu };

struct DenseLayerSpec {
  std::vector<int> sources;  // earlier nodes
  int outputs = 0;
  Activation activation = Activation::relu;
};

struct DenseNetworkSpec {
  std::vector<int> inputs;  // rows of each; 0: absent
  std::vector<DenseLayerSpec> layers;

  int node_rows(int node) const {
    const int given = int(inputs.size());
    return node < given ? inputs[std::size_t(node)] : layers[std::size_t(node - given)].outputs;
  }
};

// Layer after layer: W of each source (outputs, rows), column-major, then b.
std::size_t parameter_count(const DenseNetworkSpec& spec);
// He's uniform initialisation; biases zero.
void initialise(const DenseNetworkSpec& spec, std::uint64_t seed, std::span<float> parameters);

template <class Real>
using DenseMatrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
template <class Real>
using DenseNodes = std::vector<DenseMatrix<Real>>;

// nodes: the inputs are given, the others are filled in.
template <class Real>
void network_forward(const DenseNetworkSpec& spec, const Real* parameters, DenseNodes<Real>& nodes);

// slopes: of the loss by each node; given for the nodes that the loss reads, zero-sized for the others.
// Overwritten: afterwards they hold the slopes by the requested inputs.
template <class Real>
void network_backward(const DenseNetworkSpec& spec, const Real* parameters, const DenseNodes<Real>& nodes,
                      std::span<const int> wanted_inputs, DenseNodes<Real>& slopes,
                      Real* parameter_gradients);  // added to

}  // namespace likeness
