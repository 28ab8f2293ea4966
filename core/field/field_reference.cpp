// Plain forward and backward passes of the field: see field_reference.h. Symbols as in field.h.
#include "core/field/field_reference.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/field/field_layout.h"

namespace likeness {
namespace {

// A corner of the cell a point lies in: entry, multi-linear weight, and the weight's derivative with respect
// to each coordinate.
template <class Real>
struct Corner {
  std::size_t entry = 0;
  Real weight = 0;
  Real slope[3] = {0, 0, 0};
};

// `point` in [0, 1]^dimensions, clamped. Returns 2^dimensions corners.
template <class Real>
int cell_corners(const GridLevel& level, int dimensions, const Real* point, Corner<Real> (&corners)[8]) {
  int cell[3] = {0, 0, 0};
  Real part[3] = {0, 0, 0};
  Real scale[3] = {0, 0, 0};
  for (int a = 0; a < dimensions; ++a) {
    const bool inside = point[a] >= 0 && point[a] <= 1;
    const Real p = std::clamp(point[a], Real(0), Real(1)) * Real(level.resolution);
    cell[a] = std::min(int(std::floor(p)), level.resolution - 1);
    part[a] = p - Real(cell[a]);
    scale[a] = inside ? Real(level.resolution) : Real(0);
  }
  const int count = 1 << dimensions;
  for (int c = 0; c < count; ++c) {
    Corner<Real>& corner = corners[c];
    std::uint32_t entry = 0;
    corner.weight = 1;
    for (int a = 0; a < dimensions; ++a) {
      const bool upper = (c >> a) & 1;
      const std::uint32_t vertex = std::uint32_t(cell[a] + upper);
      entry = level.hashed ? entry ^ (vertex * kHashPrime[a]) : entry + vertex * level.stride[a];
      corner.weight *= upper ? part[a] : Real(1) - part[a];
    }
    corner.entry = level.hashed ? entry & level.mask : entry;
    for (int a = 0; a < dimensions; ++a) {
      Real slope = ((c >> a) & 1) ? scale[a] : -scale[a];
      for (int b = 0; b < dimensions; ++b) {
        if (b != a) slope *= ((c >> b) & 1) ? part[b] : Real(1) - part[b];
      }
      corner.slope[a] = slope;
    }
  }
  return count;
}

template <class Real>
void encode(const std::vector<GridLevel>& levels, const GridConfig& grid, const Real* parameters,
            const Real* point, Real* features) {
  Corner<Real> corners[8];
  for (const GridLevel& level : levels) {
    const int count = cell_corners(level, grid.dimensions, point, corners);
    for (int f = 0; f < grid.features; ++f) {
      Real sum = 0;
      for (int c = 0; c < count; ++c) {
        sum += corners[c].weight * parameters[level.offset + corners[c].entry * grid.features + f];
      }
      *features++ = sum;
    }
  }
}

template <class Real>
Real border_distance(const std::vector<GridLevel>& levels, int dimensions, const Real* point) {
  Real nearest = 1;
  for (const GridLevel& level : levels) {
    for (int a = 0; a < dimensions; ++a) {
      const Real p = point[a] * Real(level.resolution);
      nearest = std::min(nearest, std::abs(p - std::round(p)));
    }
  }
  return nearest;
}

// Adds to the tables' gradient and to the gradient of the point.
template <class Real>
void encode_backward(const std::vector<GridLevel>& levels, const GridConfig& grid, const Real* parameters,
                     const Real* point, const Real* feature_gradients, Real* parameter_gradients,
                     Real* point_gradient) {
  Corner<Real> corners[8];
  for (const GridLevel& level : levels) {
    const int count = cell_corners(level, grid.dimensions, point, corners);
    for (int f = 0; f < grid.features; ++f) {
      const Real gradient = *feature_gradients++;
      for (int c = 0; c < count; ++c) {
        const std::size_t i = level.offset + corners[c].entry * grid.features + f;
        parameter_gradients[i] += corners[c].weight * gradient;
        for (int a = 0; a < grid.dimensions; ++a) {
          point_gradient[a] += corners[c].slope[a] * parameters[i] * gradient;
        }
      }
    }
  }
}

// Activations of a network: values[0] the input, values[l + 1] the output of layer l (after ReLU, except the
// last).
template <class Real>
using Activations = std::vector<std::vector<Real>>;

template <class Real>
void network_forward(const std::vector<DenseLayer>& layers, const Real* parameters, Activations<Real>& values,
                     Real& margin) {
  values.resize(layers.size() + 1);
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const DenseLayer& layer = layers[l];
    values[l + 1].assign(layer.outputs, Real(0));
    for (int o = 0; o < layer.outputs; ++o) {
      Real sum = parameters[layer.biases + o];
      for (int i = 0; i < layer.inputs; ++i) {
        sum += parameters[layer.weights + std::size_t(o) * layer.inputs + i] * values[l][i];
      }
      if (l + 1 < layers.size()) margin = std::min(margin, std::abs(sum));
      values[l + 1][o] = l + 1 < layers.size() ? std::max(sum, Real(0)) : sum;
    }
  }
}

// Gradient of the output in, gradient of the input out.
template <class Real>
std::vector<Real> network_backward(const std::vector<DenseLayer>& layers, const Real* parameters,
                                   const Activations<Real>& values, std::vector<Real> gradient,
                                   Real* parameter_gradients) {
  for (std::size_t l = layers.size(); l-- > 0;) {
    const DenseLayer& layer = layers[l];
    std::vector<Real> below(layer.inputs, Real(0));
    for (int o = 0; o < layer.outputs; ++o) {
      if (l + 1 < layers.size() && values[l + 1][o] <= 0) continue;
      parameter_gradients[layer.biases + o] += gradient[o];
      for (int i = 0; i < layer.inputs; ++i) {
        const std::size_t w = layer.weights + std::size_t(o) * layer.inputs + i;
        parameter_gradients[w] += gradient[o] * values[l][i];
        below[i] += gradient[o] * parameters[w];
      }
    }
    gradient = std::move(below);
  }
  return gradient;
}

template <class Real>
void direction_harmonics(Real x, Real y, Real z, Real* out) {
  out[0] = Real(kHarmonic0);
  out[1] = Real(kHarmonic1) * y;
  out[2] = Real(kHarmonic1) * z;
  out[3] = Real(kHarmonic1) * x;
  out[4] = Real(kHarmonic2) * x * y;
  out[5] = Real(kHarmonic2) * y * z;
  out[6] = Real(kHarmonic2z) * (3 * z * z - 1);
  out[7] = Real(kHarmonic2) * x * z;
  out[8] = Real(kHarmonic2xy) * (x * x - y * y);
}

template <class Real>
struct Density {
  Real sigma, slope;
};
template <class Real>
Density<Real> density_of(Real raw) {
  const Real knee = Real(kDensityKnee);
  const Real bounded = std::exp(std::min(raw, knee));
  return {raw > knee ? bounded * (1 + raw - knee) : bounded, bounded};
}

// Everything computed for one sample.
template <class Real>
struct Sample {
  Real point[3];
  std::vector<Real> w, w01;  // slice in (-1, 1) and the same in (0, 1)
  Activations<Real> slice{1}, density{1}, colour{1};
  Real margin = 0;  // see reference_margin()
  Real sigma = 0, sigma_slope = 0, rgb[3] = {0, 0, 0};
};

template <class Real>
struct Evaluator {
  const FieldConfig& config;
  FieldLayout layout;
  const Real* parameters;
  const ReferenceSamples<Real>& samples;

  Evaluator(const FieldConfig& c, std::span<const Real> p, const ReferenceSamples<Real>& s)
      : config(c), layout(make_layout(c)), parameters(p.data()), samples(s) {
    LIKENESS_CHECK(p.size() == layout.parameter_count, "%zu parameters for a field of %zu", p.size(),
                   layout.parameter_count);
  }
  // The weight of entry k of psi at sample n.
  Real weight(std::size_t n, int k) const {
    const int local = k - (config.condition_count - config.local_conditions);
    return local < 0 ? Real(1) : samples.local[std::size_t(local) * samples.x.size() + n];
  }
  void append_condition(std::size_t n, std::vector<Real>& to) const {
    const Real* psi = samples.conditions.data() + std::size_t(samples.view[n]) * config.condition_count;
    for (int k = 0; k < config.condition_count; ++k) to.push_back(weight(n, k) * psi[k]);
  }

  void forward(std::size_t n, Sample<Real>& s) const {
    s.point[0] = samples.x[n], s.point[1] = samples.y[n], s.point[2] = samples.z[n];
    std::vector<Real> e(layout.position_features);
    encode(layout.position, config.position, parameters, s.point, e.data());
    s.margin = border_distance(layout.position, 3, s.point);
    std::vector<Real> input = e;
    if (layout.has_ambient()) {
      s.slice[0].assign(e.begin(), e.begin() + layout.slice_features);
      append_condition(n, s.slice[0]);
      network_forward(layout.slice, parameters, s.slice, s.margin);
      s.w.assign(layout.ambient_dimensions, Real(0)), s.w01.assign(layout.ambient_dimensions, Real(0));
      for (int a = 0; a < layout.ambient_dimensions; ++a) {
        s.w[a] = std::tanh(s.slice.back()[a]);
        s.w01[a] = Real(0.5) * s.w[a] + Real(0.5);
      }
      input.insert(input.end(), layout.ambient_features, Real(0));
      encode(layout.ambient, config.ambient_grid, parameters, s.w01.data(),
             input.data() + layout.position_features);
      s.margin = std::min(s.margin, border_distance(layout.ambient, layout.ambient_dimensions, s.w01.data()));
    } else if (layout.concat_count > 0) {
      append_condition(n, input);
    }
    s.density[0] = input;
    network_forward(layout.density, parameters, s.density, s.margin);
    const Density<Real> density = density_of(s.density.back()[0]);
    s.sigma = density.sigma, s.sigma_slope = density.slope;
    forward_colour(n, s);
  }

  void forward_colour(std::size_t n, Sample<Real>& s) const {
    std::vector<Real>& input = s.colour[0];
    input.assign(s.density.back().begin() + 1, s.density.back().end());
    if (layout.direction_features > 0) {
      input.insert(input.end(), kDirectionFeatures, Real(0));
      direction_harmonics(samples.dx[n], samples.dy[n], samples.dz[n],
                          &input[input.size() - kDirectionFeatures]);
    }
    for (int l = 0; l < config.latent_count; ++l) {
      input.push_back(samples.latents.empty()
                          ? Real(0)
                          : samples.latents[std::size_t(samples.view[n]) * config.latent_count + l]);
    }
    network_forward(layout.colour, parameters, s.colour, s.margin);
    for (int c = 0; c < 3; ++c) s.rgb[c] = 1 / (1 + std::exp(-s.colour.back()[c]));
  }

  // `sigma` and `rgb`: gradients of the outputs.
  void backward(std::size_t n, const Sample<Real>& s, Real sigma, const Real (&rgb)[3],
                ReferenceGradients<Real>& g) const {
    Real* weights = g.parameters.data();
    std::vector<Real> out(3);
    for (int c = 0; c < 3; ++c) out[c] = rgb[c] * s.rgb[c] * (1 - s.rgb[c]);
    const std::vector<Real> colour = network_backward(layout.colour, parameters, s.colour, out, weights);
    if (!g.latents.empty()) {
      const std::size_t first = config.geometry_features + layout.direction_features;
      for (int l = 0; l < config.latent_count; ++l) {
        g.latents[std::size_t(samples.view[n]) * config.latent_count + l] += colour[first + l];
      }
    }
    out.assign(1, sigma * s.sigma_slope);
    out.insert(out.end(), colour.begin(), colour.begin() + config.geometry_features);
    std::vector<Real> below = network_backward(layout.density, parameters, s.density, out, weights);
    Real* psi = g.conditions.data() + std::size_t(samples.view[n]) * config.condition_count;
    Real point[3] = {0, 0, 0};
    if (layout.has_ambient()) {
      Real w01[3] = {0, 0, 0};
      encode_backward(layout.ambient, config.ambient_grid, parameters, s.w01.data(),
                      below.data() + layout.position_features, weights, w01);
      out.assign(layout.ambient_dimensions, Real(0));
      for (int a = 0; a < layout.ambient_dimensions; ++a) {
        out[a] = Real(0.5) * w01[a] * (1 - s.w[a] * s.w[a]);
      }
      const std::vector<Real> slice = network_backward(layout.slice, parameters, s.slice, out, weights);
      for (int i = 0; i < layout.slice_features; ++i) below[i] += slice[i];
      for (int k = 0; k < config.condition_count; ++k)
        psi[k] += weight(n, k) * slice[layout.slice_features + k];
    } else {
      for (int k = 0; k < layout.concat_count; ++k)
        psi[k] += weight(n, k) * below[layout.position_features + k];
    }
    encode_backward(layout.position, config.position, parameters, s.point, below.data(), weights, point);
    g.x[n] = point[0], g.y[n] = point[1], g.z[n] = point[2];
  }
};

}  // namespace

template <class Real>
ReferenceOutputs<Real> reference_forward(const FieldConfig& config, std::span<const Real> parameters,
                                         const ReferenceSamples<Real>& samples) {
  const Evaluator<Real> evaluator(config, parameters, samples);
  ReferenceOutputs<Real> out;
  Sample<Real> s;
  for (std::size_t n = 0; n < samples.x.size(); ++n) {
    evaluator.forward(n, s);
    out.sigma.push_back(s.sigma);
    out.red.push_back(s.rgb[0]), out.green.push_back(s.rgb[1]), out.blue.push_back(s.rgb[2]);
  }
  return out;
}

template <class Real>
ReferenceGradients<Real> reference_backward(const FieldConfig& config, std::span<const Real> parameters,
                                            const ReferenceSamples<Real>& samples,
                                            const ReferenceOutputs<Real>& output_gradients) {
  const Evaluator<Real> evaluator(config, parameters, samples);
  const std::size_t count = samples.x.size();
  ReferenceGradients<Real> g;
  g.parameters.assign(parameters.size(), Real(0));
  g.conditions.assign(samples.conditions.size(), Real(0));
  g.latents.assign(samples.latents.size(), Real(0));
  g.x.assign(count, Real(0)), g.y.assign(count, Real(0)), g.z.assign(count, Real(0));
  Sample<Real> s;
  for (std::size_t n = 0; n < count; ++n) {
    evaluator.forward(n, s);
    const Real rgb[3] = {output_gradients.red[n], output_gradients.green[n], output_gradients.blue[n]};
    evaluator.backward(n, s, output_gradients.sigma[n], rgb, g);
  }
  return g;
}

template <class Real>
std::vector<Real> reference_slice(const FieldConfig& config, std::span<const Real> parameters,
                                  const ReferenceSamples<Real>& samples) {
  const Evaluator<Real> evaluator(config, parameters, samples);
  std::vector<Real> w;
  Sample<Real> s;
  for (std::size_t n = 0; n < samples.x.size(); ++n) {
    evaluator.forward(n, s);
    w.insert(w.end(), s.w.begin(), s.w.end());
  }
  return w;
}

template <class Real>
std::vector<Real> reference_margin(const FieldConfig& config, std::span<const Real> parameters,
                                   const ReferenceSamples<Real>& samples) {
  const Evaluator<Real> evaluator(config, parameters, samples);
  std::vector<Real> margin;
  Sample<Real> s;
  for (std::size_t n = 0; n < samples.x.size(); ++n) {
    evaluator.forward(n, s);
    margin.push_back(s.margin);
  }
  return margin;
}

template <class Real>
ReferenceSamples<Real> reference_samples(const FieldConfig& config, const FieldInputs& inputs,
                                         std::size_t views) {
  const std::size_t n = inputs.count;
  ReferenceSamples<Real> s;
  s.x.assign(inputs.x, inputs.x + n), s.y.assign(inputs.y, inputs.y + n), s.z.assign(inputs.z, inputs.z + n);
  s.dx.assign(n, Real(0)), s.dy.assign(n, Real(0)), s.dz.assign(n, Real(1));
  if (inputs.dx) {
    s.dx.assign(inputs.dx, inputs.dx + n), s.dy.assign(inputs.dy, inputs.dy + n);
    s.dz.assign(inputs.dz, inputs.dz + n);
  }
  s.view.assign(n, 0);
  if (inputs.view) s.view.assign(inputs.view, inputs.view + n);
  if (inputs.conditions) {
    s.conditions.assign(inputs.conditions, inputs.conditions + views * config.condition_count);
  }
  if (inputs.local) s.local.assign(inputs.local, inputs.local + n * std::size_t(config.local_conditions));
  if (inputs.latents) s.latents.assign(inputs.latents, inputs.latents + views * config.latent_count);
  return s;
}

#define LIKENESS_INSTANTIATE(Real)                                                                \
  template ReferenceOutputs<Real> reference_forward(const FieldConfig&, std::span<const Real>,    \
                                                    const ReferenceSamples<Real>&);               \
  template ReferenceGradients<Real> reference_backward(const FieldConfig&, std::span<const Real>, \
                                                       const ReferenceSamples<Real>&,             \
                                                       const ReferenceOutputs<Real>&);            \
  template std::vector<Real> reference_slice(const FieldConfig&, std::span<const Real>,           \
                                             const ReferenceSamples<Real>&);                      \
  template std::vector<Real> reference_margin(const FieldConfig&, std::span<const Real>,          \
                                              const ReferenceSamples<Real>&);                     \
  template ReferenceSamples<Real> reference_samples(const FieldConfig&, const FieldInputs&, std::size_t);
LIKENESS_INSTANTIATE(float)
LIKENESS_INSTANTIATE(double)
#undef LIKENESS_INSTANTIATE

}  // namespace likeness
