// Encodings and networks of the baselines' fields.
#include "core/papers/nerf_field.h"

#include <array>
#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace likeness {
namespace {

constexpr double kDensity = 40, kDensityShift = -2;  // a haze of 5 per cube side before anything is learnt
enum RadianceInput { kPosition, kCondition, kDirection, kRadianceInputs };
enum SliceInput { kSlicePosition, kSlicePsi, kSliceInputs };

int encoded_rows(int count, int frequencies) { return count * (1 + 2 * frequencies); }

// Rows: p, then for every frequency the sines of all coordinates and their cosines.
template <class Real>
void encode(const DenseMatrix<Real>& p, int frequencies, DenseMatrix<Real>& out) {
  const auto rows = p.rows();
  out.resize(encoded_rows(int(rows), frequencies), p.cols());
  out.topRows(rows) = p;
  for (Eigen::Index c = 0; c < p.cols(); ++c)
    for (Eigen::Index r = 0; r < rows; ++r) {
      Real sine = std::sin(std::numbers::pi_v<Real> * p(r, c)),
           cosine = std::cos(std::numbers::pi_v<Real> * p(r, c));
      for (int k = 0; k < frequencies; ++k) {
        out(rows * (1 + 2 * k) + r, c) = sine;
        out(rows * (2 + 2 * k) + r, c) = cosine;
        const Real twice = 2 * sine * cosine;
        cosine = cosine * cosine - sine * sine;
        sine = twice;
      }
    }
}

// Slopes by p from those by its encoding.
template <class Real>
DenseMatrix<Real> encode_backward(const DenseMatrix<Real>& encoded, int frequencies,
                                  const DenseMatrix<Real>& slopes, int rows) {
  DenseMatrix<Real> out = slopes.topRows(rows);
  Real factor = std::numbers::pi_v<Real>;
  for (int k = 0; k < frequencies; ++k, factor *= 2) {
    const int sines = rows * (1 + 2 * k), cosines = rows * (2 + 2 * k);
    out.array() +=
        factor * (slopes.middleRows(sines, rows).array() * encoded.middleRows(cosines, rows).array() -
                  slopes.middleRows(cosines, rows).array() * encoded.middleRows(sines, rows).array());
  }
  return out;
}

DenseNetworkSpec slice_spec(const NerfConfig& c) {
  DenseNetworkSpec spec;
  if (!c.slice || c.condition_count == 0) return spec;
  spec.inputs = {encoded_rows(3, c.position_frequencies), c.condition_count};
  for (int l = 0; l <= c.slice_layers; ++l) {
    std::vector<int> sources;
    if (l > 0) sources.push_back(kSliceInputs + l - 1);
    if (l == 0 || l == c.slice_skip) sources.insert(sources.end(), {kSlicePosition, kSlicePsi});
    const bool last = l == c.slice_layers;
    spec.layers.push_back(
        {sources, last ? c.slice_count : c.slice_width, last ? Activation::none : Activation::relu});
  }
  return spec;
}

int sigma_node(const NerfConfig& c) { return kRadianceInputs + c.layers; }
int colour_node(const NerfConfig& c) { return sigma_node(c) + 3; }

DenseNetworkSpec radiance_spec(const NerfConfig& c) {
  DenseNetworkSpec spec;
  const int expression = c.condition_count == 0 ? 0
                         : c.slice              ? encoded_rows(c.slice_count, c.slice_frequencies)
                                                : c.condition_count;
  spec.inputs = {encoded_rows(3, c.position_frequencies), expression,
                 c.direction_frequencies > 0 ? encoded_rows(3, c.direction_frequencies) : 0};
  for (int l = 0; l < c.layers; ++l) {
    std::vector<int> sources;
    if (l > 0) sources.push_back(kRadianceInputs + l - 1);
    if (l == 0 || l == c.skip) sources.insert(sources.end(), {kPosition, kCondition});
    spec.layers.push_back({sources, c.width, Activation::relu});
  }
  const int trunk = kRadianceInputs + c.layers - 1;
  spec.layers.push_back({{trunk}, 1, Activation::none});
  spec.layers.push_back({{trunk}, c.width, Activation::none});
  spec.layers.push_back({{trunk + 2, kDirection}, c.width / 2, Activation::relu});
  spec.layers.push_back({{trunk + 3}, 3, Activation::none});
  return spec;
}

template <class Real>
Real softplus(Real v) {
  return v > 30 ? v : std::log1p(std::exp(v));
}
template <class Real>
Real logistic(Real v) {
  return Real(1) / (Real(1) + std::exp(-v));
}

}  // namespace

NerfField<float> make_nerf_field(const NerfConfig& config, std::uint64_t seed) {
  LIKENESS_CHECK(config.layers > 0 && config.width > 1, "%d layers of %d", config.layers, config.width);
  NerfField<float> field{config, slice_spec(config), radiance_spec(config), {}};
  const std::size_t own = parameter_count(field.slice);
  field.parameters.resize(own + parameter_count(field.radiance));
  const std::span<float> all(field.parameters);
  initialise(field.slice, 2 * seed, all.first(own));
  initialise(field.radiance, 2 * seed + 1, all.subspan(own));
  // A slice near the origin of the hyper-space, as HyperNeRF begins.
  if (own > 0) {
    const std::size_t last = std::size_t(config.slice_count) * (config.slice_width + 1);
    for (float& v : all.first(own).last(last)) v *= 0.1f;
  }
  return field;
}

NerfField<double> in_double(const NerfField<float>& field) {
  return {field.config, field.slice, field.radiance,
          std::vector<double>(field.parameters.begin(), field.parameters.end())};
}

NerfInputs<float> nerf_inputs(const NerfConfig& config, const FieldSamples& samples, std::size_t begin,
                              std::size_t end, const float* conditions) {
  const auto n = Eigen::Index(end - begin);
  NerfInputs<float> in{DenseMatrix<float>(3, n), DenseMatrix<float>(3, n),
                       DenseMatrix<float>(config.condition_count, n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t s = begin + std::size_t(i);
    in.position.col(i) << samples.x[s], samples.y[s], samples.z[s];
    in.direction.col(i) << samples.dx[s], samples.dy[s], samples.dz[s];
    for (int k = 0; k < config.condition_count; ++k)
      in.condition(k, i) = conditions[std::ptrdiff_t(samples.view[s]) * config.condition_count + k];
  }
  return in;
}

template <class Real>
NerfOutputs<Real> nerf_forward(const NerfField<Real>& field, const NerfInputs<Real>& inputs,
                               NerfTape<Real>& tape, NerfWanted wanted) {
  const NerfConfig& c = field.config;
  const DenseMatrix<Real> centred = (Real(2) * inputs.position).array() - Real(1);
  tape.radiance.resize(kRadianceInputs);
  encode(centred, c.position_frequencies, tape.radiance[kPosition]);
  if (field.slice.layers.empty()) {
    tape.radiance[kCondition] = inputs.condition;
  } else {
    tape.slice.resize(kSliceInputs);
    tape.slice[kSlicePosition] = tape.radiance[kPosition];
    tape.slice[kSlicePsi] = inputs.condition;
    network_forward(field.slice, field.parameters.data(), tape.slice);
    encode(tape.slice.back(), c.slice_frequencies, tape.radiance[kCondition]);
  }
  if (c.direction_frequencies > 0)
    encode(inputs.direction, c.direction_frequencies, tape.radiance[kDirection]);
  else
    tape.radiance[kDirection].resize(0, inputs.position.cols());

  const Real* parameters = field.parameters.data() + parameter_count(field.slice);
  NerfOutputs<Real> out;
  if (wanted == NerfWanted::density) {
    DenseNetworkSpec spec = field.radiance;
    spec.layers.resize(std::size_t(c.layers) + 1);
    network_forward(spec, parameters, tape.radiance);
  } else {
    network_forward(field.radiance, parameters, tape.radiance);
    out.colour = tape.radiance[std::size_t(colour_node(c))].unaryExpr([](Real v) { return logistic(v); });
  }
  out.sigma = tape.radiance[std::size_t(sigma_node(c))].unaryExpr(
      [](Real v) { return Real(kDensity) * softplus(v + Real(kDensityShift)); });
  return out;
}

template <class Real>
void nerf_backward(const NerfField<Real>& field, const NerfTape<Real>& tape, const NerfOutputs<Real>& outputs,
                   const NerfOutputs<Real>& slopes, std::vector<Real>& gradients) {
  const NerfConfig& c = field.config;
  const std::size_t own = parameter_count(field.slice);
  DenseNodes<Real> by(tape.radiance.size());
  const DenseMatrix<Real>& raw = tape.radiance[std::size_t(sigma_node(c))];
  by[std::size_t(sigma_node(c))] =
      slopes.sigma.array() *
      raw.unaryExpr([](Real v) { return Real(kDensity) * logistic(v + Real(kDensityShift)); }).array();
  by[std::size_t(colour_node(c))] =
      slopes.colour.array() * outputs.colour.array() * (Real(1) - outputs.colour.array());
  const std::array<int, 1> expression{kCondition};
  const std::span<const int> wanted(expression.data(), own > 0 ? 1 : 0);
  network_backward(field.radiance, field.parameters.data() + own, tape.radiance, wanted, by,
                   gradients.data() + own);
  if (own == 0) return;
  DenseNodes<Real> by_slice(tape.slice.size());
  by_slice.back() =
      encode_backward(tape.radiance[kCondition], c.slice_frequencies, by[kCondition], c.slice_count);
  network_backward(field.slice, field.parameters.data(), tape.slice, {}, by_slice, gradients.data());
}

template NerfOutputs<float> nerf_forward(const NerfField<float>&, const NerfInputs<float>&, NerfTape<float>&,
                                         NerfWanted);
template NerfOutputs<double> nerf_forward(const NerfField<double>&, const NerfInputs<double>&,
                                          NerfTape<double>&, NerfWanted);
template void nerf_backward(const NerfField<float>&, const NerfTape<float>&, const NerfOutputs<float>&,
                            const NerfOutputs<float>&, std::vector<float>&);
template void nerf_backward(const NerfField<double>&, const NerfTape<double>&, const NerfOutputs<double>&,
                            const NerfOutputs<double>&, std::vector<double>&);

}  // namespace likeness
