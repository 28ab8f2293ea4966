// The fields that the papers compare with: multi-layer perceptrons on positional encodings, after Mildenhall
// et al. 2020 (NeRF), with the expression psi concatenated to the position (Gafni et al. 2021, NeRFace), or
// with a slice through a hyper-space that psi chooses (Park et al. 2021, HyperNeRF).
//
//   gamma_L(p) = p, sin(2^k pi p), cos(2^k pi p), k < L       p in [-1, 1]
//   h = trunk(gamma(x), e)        e = psi, or gamma(w) with w = H(gamma(x), psi), or nothing
//   sigma = 40 softplus(s(h) - 2) per cube side, c = sigmoid(C(f(h), gamma(d)))
//
// In float, or in double for finite differences.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/papers/dense_network.h"
#include "core/render/rays.h"

namespace likeness {

struct NerfConfig {
  int position_frequencies = 10, direction_frequencies = 4;  // directions: 0 frequencies = no view at all
  int width = 256, layers = 8;
  int skip = 5;             // the layer that reads the inputs again
  int condition_count = 0;  // K: entries of psi; 0 = no expression
  // H: 6 layers of 64 to two coordinates, which are encoded in turn. False: psi is concatenated.
  bool slice = false;
  int slice_width = 64, slice_layers = 6, slice_skip = 4, slice_count = 2, slice_frequencies = 4;
};

template <class Real>
struct NerfField {
  NerfConfig config;
  DenseNetworkSpec slice, radiance;  // no layers: no slice
  std::vector<Real> parameters;      // of the slice, then of the rest
};
NerfField<float> make_nerf_field(const NerfConfig& config, std::uint64_t seed);
NerfField<double> in_double(const NerfField<float>& field);

template <class Real>
struct NerfInputs {
  DenseMatrix<Real> position;   // (3, N) in [0, 1] of the field's cube
  DenseMatrix<Real> direction;  // (3, N) unit
  DenseMatrix<Real> condition;  // (K, N)
};
// Samples [begin, end); conditions: (views, K).
NerfInputs<float> nerf_inputs(const NerfConfig& config, const FieldSamples& samples, std::size_t begin,
                              std::size_t end, const float* conditions);

// What the forward pass keeps for the backward pass.
template <class Real>
struct NerfTape {
  DenseNodes<Real> slice, radiance;
};

template <class Real>
struct NerfOutputs {
  DenseMatrix<Real> sigma;   // (1, N) per cube side
  DenseMatrix<Real> colour;  // (3, N) in [0, 1]; no columns if only densities were requested
};

enum class NerfWanted { density, all };

template <class Real>
NerfOutputs<Real> nerf_forward(const NerfField<Real>& field, const NerfInputs<Real>& inputs,
                               NerfTape<Real>& tape, NerfWanted wanted = NerfWanted::all);

// slopes: of the loss by the outputs, in their shapes. Adds to gradients (laid out as the parameters).
template <class Real>
void nerf_backward(const NerfField<Real>& field, const NerfTape<Real>& tape, const NerfOutputs<Real>& outputs,
                   const NerfOutputs<Real>& slopes, std::vector<Real>& gradients);

}  // namespace likeness
