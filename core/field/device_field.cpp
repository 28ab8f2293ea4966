// A field on a device: see device_field.h.
#include "core/field/device_field.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/field/field_layout.h"
#include "core/field/network_math.h"

namespace likeness {
namespace {

constexpr std::size_t kCorrections = 4097;  // the correction is 1 to float precision long before
constexpr std::size_t kSampleArrays = 7;    // position, direction, view

DeviceGrid device_grid(const GridConfig& config, const std::vector<GridLevel>& levels) {
  DeviceGrid grid{config.dimensions, config.levels, config.features, {}};
  std::copy(levels.begin(), levels.end(), grid.level);
  return grid;
}

DeviceNetwork device_network(const std::vector<DenseLayer>& layers) {
  DeviceNetwork network{};
  network.layers = std::int32_t(layers.size());
  for (std::size_t l = 0; l < layers.size(); ++l) {
    DeviceLayer& layer = network.layer[l];
    layer.inputs = layers[l].inputs, layer.outputs = layers[l].outputs;
    layer.stride = padded(layer.inputs) + 8;
    layer.weights = std::uint32_t(layers[l].weights), layer.biases = std::uint32_t(layers[l].biases);
    layer.shared_weights = network.weight_count, layer.shared_biases = network.bias_count;
    network.weight_count += std::uint32_t(padded(layer.outputs) * layer.stride);
    network.bias_count += std::uint32_t(padded(layer.outputs));
  }
  return network;
}

// Rows of floats that a batch keeps per sample.
struct BatchRows {
  std::size_t features, slice, density, colour;
  explicit BatchRows(const FieldLayout& layout)
      : features(std::size_t(layout.position_features + layout.ambient_features)),
        slice(std::size_t(layout.ambient_dimensions)),
        density(std::size_t(layout.density.back().outputs)),
        colour(3) {}
  std::size_t all() const { return features + slice + density + colour; }
};

// Blocks of threads that may each keep their own sums of a network's gradients.
std::size_t blocks_that_sum(const DeviceFacts& facts) { return 2 * std::size_t(facts.multiprocessors); }

std::size_t widest_network(const FieldLayout& layout) {
  std::size_t most = 0;
  for (const std::vector<DenseLayer>* network : {&layout.slice, &layout.density, &layout.colour}) {
    std::size_t parameters = 0;
    for (const DenseLayer& layer : *network)
      parameters += std::size_t(layer.outputs) * std::size_t(layer.inputs + 1);
    most = std::max(most, parameters);
  }
  return most;
}

// Of the blocks' own sums, which only the matrix units keep.
std::size_t partial_floats(const FieldLayout& layout, const DeviceFieldOptions& options,
                           const DeviceFacts& facts) {
  return options.precision == NetworkPrecision::bf16 ? blocks_that_sum(facts) * widest_network(layout) : 0;
}

}  // namespace

std::vector<float> adam_corrections(const AdamOptions& options, std::size_t count) {
  std::vector<float> corrections(count);
  double power1 = 1, power2 = 1;
  for (float& correction : corrections) {
    correction = power1 < 1 ? float(std::sqrt(1 - power2) / (1 - power1)) : 0.0f;
    power1 *= double(options.beta1), power2 *= double(options.beta2);
  }
  return corrections;
}

bool fit_network(NetworkArgs& args, std::size_t shared_bytes, bool backward) {
  const std::size_t value = args.precision == NetworkPrecision::bf16 ? 2 : 4;
  for (const bool sums : {true, false})
    for (const int rows : {64, 32, 16}) {
      args.rows = rows;
      args.shared_sums = backward && sums;
      if (network_memory(args, value, backward).end <= shared_bytes) return true;
      if (!backward && rows == 16) return false;
    }
  return false;
}

std::size_t device_field_bytes(const FieldConfig& config, const DeviceFieldOptions& options,
                               const DeviceFacts& facts) {
  const FieldLayout layout = make_layout(config);
  const std::size_t lines = layout.table_count / kTableLine;
  const std::size_t rows = kSampleArrays + BatchRows(layout).all() * (options.training ? 2 : 1);
  std::size_t floats = layout.parameter_count * (options.training ? 4 : 1) + options.capacity * rows;
  floats +=
      options.views * std::size_t(config.condition_count + config.latent_count * (options.training ? 2 : 1));
  if (options.training) floats += lines + kCorrections + partial_floats(layout, options, facts);
  return 4 * (floats + 1);
}

struct DeviceField::Impl {
  std::shared_ptr<Device> device;
  FieldConfig config;
  FieldLayout layout;
  DeviceFieldOptions options;
  bool has_codes = false;
  DeviceArray<float> parameters, gradients, first, second, corrections, partial;
  DeviceArray<std::uint32_t> line_steps, number;  // number: of samples
  DeviceArray<float> samples, conditions, codes, d_codes;
  DeviceArray<std::int32_t> view;
  DeviceArray<float> features, slice, density, colour, d_features, d_slice, d_density, d_colour;
  std::vector<float> host_corrections;
  // Arguments, made once.
  EncodeArgs position{}, ambient{};
  EncodeBackwardArgs position_back{}, ambient_back{};
  NetworkArgs slice_net{}, density_net{}, colour_net{}, slice_back{}, density_back{}, colour_back{};

  float* axis(std::size_t k) const { return samples.data() + k * options.capacity; }

  template <class T>
  Result<void> make(DeviceArray<T>& array, std::size_t count) {
    auto made = DeviceArray<T>::make(device, count);
    if (!made) return made.error();
    array = std::move(*made);
    return {};
  }
  Result<void> allocate();
  Result<void> clear_state();
  NetworkArgs network(const std::vector<DenseLayer>& layers, NetworkOutput output, float* out) const;
  void describe();
  bool fit();
};

Result<void> DeviceField::Impl::allocate() {
  const std::size_t n = options.capacity, p = layout.parameter_count;
  const BatchRows rows(layout);
  const std::size_t latents = options.views * std::size_t(config.latent_count);
  std::vector<std::pair<DeviceArray<float>*, std::size_t>> wanted = {
      {&parameters, p},
      {&samples, 6 * n},
      {&features, n * rows.features},
      {&slice, n * rows.slice},
      {&density, n * rows.density},
      {&colour, n * rows.colour},
      {&conditions, options.views * std::size_t(config.condition_count)},
      {&codes, latents}};
  if (options.training)
    for (const auto& more :
         std::initializer_list<std::pair<DeviceArray<float>*, std::size_t>>{{&gradients, p},
                                                                            {&first, p},
                                                                            {&second, p},
                                                                            {&corrections, kCorrections},
                                                                            {&d_features, n * rows.features},
                                                                            {&d_slice, n * rows.slice},
                                                                            {&d_density, n * rows.density},
                                                                            {&d_colour, n * rows.colour},
                                                                            {&d_codes, latents}})
      wanted.push_back(more);
  for (auto& [array, count] : wanted)
    if (auto made = make(*array, count); !made) return made;
  if (auto made = make(view, n); !made) return made;
  if (auto made = make(number, 1); !made) return made;
  if (!options.training) return {};
  const std::size_t lines = layout.table_count / kTableLine;
  if (auto made = make(partial, partial_floats(layout, options, device->facts())); !made) return made;
  return make(line_steps, lines);
}

// Clears what no copy from the host sets.
Result<void> DeviceField::Impl::clear_state() {
  const auto zero = [&](auto& array) {
    return device->clear(array.data(), array.size() * sizeof(*array.data()));
  };
  if (auto done = zero(number); !done) return done;
  if (!options.training) return {};
  for (DeviceArray<float>* array : {&gradients, &first, &second, &d_codes, &d_density})
    if (auto done = zero(*array); !done) return done;
  if (auto done = zero(line_steps); !done) return done;
  host_corrections = adam_corrections({}, kCorrections);
  return device->copy_in(corrections.data(), host_corrections.data(), kCorrections * sizeof(float));
}

NetworkArgs DeviceField::Impl::network(const std::vector<DenseLayer>& layers, NetworkOutput output,
                                       float* out) const {
  NetworkArgs a{};
  a.network = device_network(layers);
  a.output = output;
  // Rounding a slice would move its samples by a fraction of a fine cell.
  const bool halves = options.precision == NetworkPrecision::bf16;
  a.precision = halves && output == NetworkOutput::slice ? NetworkPrecision::split : options.precision;
  a.parameters = parameters.data(), a.gradients = gradients.data();
  a.view = options.views > 1 ? view.data() : nullptr, a.count = number.data(),
  a.capacity = std::uint32_t(options.capacity);
  a.out = out;
  a.partial = halves ? partial.data() : nullptr,
  a.partial_blocks = std::uint32_t(blocks_that_sum(device->facts()));
  for (std::size_t k = 0; k < 3; ++k) a.direction[k] = axis(3 + k);
  return a;
}

void DeviceField::Impl::describe() {
  const std::size_t n = options.capacity, e = std::size_t(layout.position_features);
  const auto capacity = std::uint32_t(n);
  position.grid = device_grid(config.position, layout.position);
  position.parameters = parameters.data(), position.features = features.data();
  position.count = number.data(), position.capacity = capacity;
  for (std::size_t k = 0; k < 3; ++k) position.point[k] = axis(k);
  if (layout.has_ambient()) {
    ambient = position;
    ambient.grid = device_grid(config.ambient_grid, layout.ambient);
    ambient.features = features.data() + e * n;
    for (std::size_t k = 0; k < 3; ++k)
      ambient.point[k] = k < std::size_t(layout.ambient_dimensions) ? slice.data() + k * n : nullptr;
    slice_net = network(layout.slice, NetworkOutput::slice, slice.data());
    slice_net.columns = features.data(), slice_net.column_count = layout.slice_features;
    slice_net.codes = conditions.data(), slice_net.code_count = config.condition_count;
  }
  density_net = network(layout.density, NetworkOutput::density, density.data());
  density_net.columns = features.data();
  density_net.column_count = layout.position_features + layout.ambient_features;
  density_net.codes = conditions.data(), density_net.code_count = layout.concat_count;
  colour_net = network(layout.colour, NetworkOutput::colour, colour.data());
  colour_net.columns = density.data() + n, colour_net.column_count = config.geometry_features;
  colour_net.direction_count = layout.direction_features;
  colour_net.code_count = config.latent_count;
  if (!options.training) return;
  position_back = {position.grid,    parameters.data(), {},      d_features.data(), {},
                   gradients.data(), number.data(),     capacity};
  std::copy(position.point, position.point + 3, position_back.point);
  if (layout.has_ambient()) {
    ambient_back = position_back;
    ambient_back.grid = ambient.grid, ambient_back.d_features = d_features.data() + e * n;
    for (std::size_t k = 0; k < 3; ++k) {
      ambient_back.point[k] = ambient.point[k];
      ambient_back.d_point[k] = ambient.point[k] ? d_slice.data() + k * n : nullptr;
    }
    slice_back = slice_net;
    slice_back.d_out = d_slice.data(), slice_back.d_columns = d_features.data(), slice_back.add_columns = 1;
  }
  density_back = density_net;
  density_back.d_out = d_density.data(), density_back.d_columns = d_features.data();
  colour_back = colour_net;
  colour_back.d_out = d_colour.data();
  colour_back.d_columns = config.geometry_features > 0 ? d_density.data() + n : nullptr;
}

bool DeviceField::Impl::fit() {
  const std::size_t shared = std::size_t(device->facts().shared_bytes);
  bool fits = fit_network(density_net, shared, false) && fit_network(colour_net, shared, false);
  if (layout.has_ambient()) fits = fits && fit_network(slice_net, shared, false);
  if (!options.training || !fits) return fits;
  NetworkArgs widest = colour_back;
  widest.d_codes = d_codes.data();
  fits = fit_network(density_back, shared, true) && fit_network(widest, shared, true);
  colour_back.rows = widest.rows, colour_back.shared_sums = widest.shared_sums;
  return fits && (!layout.has_ambient() || fit_network(slice_back, shared, true));
}

DeviceField::DeviceField(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DeviceField::~DeviceField() = default;

Result<std::unique_ptr<DeviceField>> DeviceField::make(std::shared_ptr<Device> device,
                                                       const FieldConfig& config,
                                                       const DeviceFieldOptions& options) {
  LIKENESS_CHECK(options.precision != NetworkPrecision::split, "a whole field of split factors (%d views)",
                 int(options.views));
  LIKENESS_CHECK(options.capacity > 0 && options.capacity <= (std::size_t{1} << 30) && options.views > 0,
                 "a batch of %zu samples, %zu views", options.capacity, options.views);
  auto impl = std::make_unique<Impl>();
  impl->device = std::move(device);
  impl->config = config, impl->layout = make_layout(config), impl->options = options;
  if (!impl->device->facts().matrix_units) impl->options.precision = NetworkPrecision::single;
  impl->describe();
  if (!impl->fit()) return device_error(DeviceStatus::too_large, impl->device->facts(), "", "");
  if (auto done = impl->allocate(); !done) return done.error();
  const NetworkArgs fitted[] = {impl->slice_net,  impl->density_net,  impl->colour_net,
                                impl->slice_back, impl->density_back, impl->colour_back};
  impl->describe();  // now with the arrays' addresses
  NetworkArgs* args[] = {&impl->slice_net,  &impl->density_net,  &impl->colour_net,
                         &impl->slice_back, &impl->density_back, &impl->colour_back};
  for (std::size_t i = 0; i < std::size(args); ++i)
    args[i]->rows = fitted[i].rows, args[i]->shared_sums = fitted[i].shared_sums;
  if (auto done = impl->clear_state(); !done) return done.error();
  return std::unique_ptr<DeviceField>(new DeviceField(std::move(impl)));
}

Result<void> DeviceField::place(const Field& field, const AdamState* adam) {
  Impl& i = *impl_;
  LIKENESS_CHECK(field.parameters.size() == i.layout.parameter_count, "%zu parameters for a field of %zu",
                 field.parameters.size(), i.layout.parameter_count);
  const std::size_t bytes = field.parameters.size() * sizeof(float);
  if (auto done = i.device->copy_in(i.parameters.data(), field.parameters.data(), bytes); !done) return done;
  if (!adam || !i.options.training) return {};
  if (auto done = i.device->copy_in(i.first.data(), adam->first.data(), bytes); !done) return done;
  if (auto done = i.device->copy_in(i.second.data(), adam->second.data(), bytes); !done) return done;
  return i.device->copy_in(i.line_steps.data(), adam->line_steps.data(),
                           adam->line_steps.size() * sizeof(std::uint32_t));
}

Result<void> DeviceField::fetch(Field& field, AdamState* adam) const {
  const Impl& i = *impl_;
  const std::size_t bytes = i.layout.parameter_count * sizeof(float);
  if (auto done = i.device->copy_out(field.parameters.data(), i.parameters.data(), bytes); !done) return done;
  if (!adam || !i.options.training) return {};
  if (auto done = i.device->copy_out(adam->first.data(), i.first.data(), bytes); !done) return done;
  if (auto done = i.device->copy_out(adam->second.data(), i.second.data(), bytes); !done) return done;
  return i.device->copy_out(adam->line_steps.data(), i.line_steps.data(),
                            adam->line_steps.size() * sizeof(std::uint32_t));
}

Result<void> DeviceField::set_samples(const FieldInputs& inputs) {
  Impl& i = *impl_;
  LIKENESS_CHECK(inputs.count <= i.options.capacity, "%zu samples for a batch of %zu", inputs.count,
                 i.options.capacity);
  const std::size_t bytes = inputs.count * sizeof(float);
  const float* axes[6] = {inputs.x, inputs.y, inputs.z, inputs.dx, inputs.dy, inputs.dz};
  for (std::size_t k = 0; k < 6; ++k)
    if (axes[k])
      if (auto done = i.device->copy_in(i.axis(k), axes[k], bytes); !done) return done;
  if (!inputs.view) return i.device->clear(i.view.data(), bytes);
  return i.device->copy_in(i.view.data(), inputs.view, bytes);
}

Result<void> DeviceField::set_conditions(const float* conditions, std::size_t rows) {
  Impl& i = *impl_;
  LIKENESS_CHECK(rows <= i.options.views, "%zu rows of conditions for %zu", rows, i.options.views);
  return i.device->copy_in(i.conditions.data(), conditions,
                           rows * std::size_t(i.config.condition_count) * sizeof(float));
}

Result<void> DeviceField::set_codes(const float* codes, std::size_t rows) {
  Impl& i = *impl_;
  LIKENESS_CHECK(rows <= i.options.views, "%zu rows of codes for %zu", rows, i.options.views);
  i.has_codes = codes != nullptr && i.config.latent_count > 0;
  for (NetworkArgs* net : {&i.colour_net, &i.colour_back})
    net->codes = i.has_codes ? i.codes.data() : nullptr;
  i.colour_back.d_codes = i.has_codes ? i.d_codes.data() : nullptr;
  if (!i.has_codes) return {};
  return i.device->copy_in(i.codes.data(), codes, rows * std::size_t(i.config.latent_count) * sizeof(float));
}

Result<void> DeviceField::set_count(std::uint32_t count) {
  static_assert(sizeof(count) == 4);
  host_count_ = count;
  return impl_->device->copy_in(impl_->number.data(), &host_count_, sizeof(host_count_));
}

Result<void> DeviceField::density() { return density(impl_->options.capacity); }

Result<void> DeviceField::density(std::size_t most) {
  Impl& i = *impl_;
  const std::size_t n = std::min(most, i.options.capacity);
  if (auto done = i.device->launch(Kernel::encode, i.position, n * i.layout.position.size()); !done)
    return done;
  if (i.layout.has_ambient()) {
    if (auto done = i.device->launch(Kernel::network_forward, i.slice_net, n); !done) return done;
    if (auto done = i.device->launch(Kernel::encode, i.ambient, n * i.layout.ambient.size()); !done)
      return done;
  }
  return i.device->launch(Kernel::network_forward, i.density_net, n);
}

Result<void> DeviceField::colour() {
  return impl_->device->launch(Kernel::network_forward, impl_->colour_net, impl_->options.capacity);
}

Result<void> DeviceField::backward() {
  Impl& i = *impl_;
  const std::size_t n = i.options.capacity;
  if (auto done = i.device->launch(Kernel::network_backward, i.colour_back, n); !done) return done;
  if (auto done = i.device->launch(Kernel::network_backward, i.density_back, n); !done) return done;
  if (i.layout.has_ambient()) {
    if (auto done = i.device->launch(Kernel::encode_backward, i.ambient_back, n); !done) return done;
    if (auto done = i.device->launch(Kernel::network_backward, i.slice_back, n); !done) return done;
  }
  return i.device->launch(Kernel::encode_backward, i.position_back, n * i.layout.position.size());
}

Result<void> DeviceField::step_tables(const StepNumbers* numbers, const StepSums* sums) {
  Impl& i = *impl_;
  const AdamOptions options;
  const AdamLinesArgs args{i.parameters.data(),
                           i.gradients.data(),
                           i.first.data(),
                           i.second.data(),
                           i.line_steps.data(),
                           i.corrections.data(),
                           kCorrections,
                           {options.beta1, options.beta2, options.table_epsilon},
                           numbers,
                           sums,
                           std::uint32_t(i.line_steps.size())};
  return i.device->launch(Kernel::adam_lines, args, i.line_steps.size());
}

Result<void> DeviceField::step_networks(const StepNumbers* numbers, const StepSums* sums, int index) {
  Impl& i = *impl_;
  const AdamOptions options;
  const std::size_t begin = i.layout.table_count, end = i.layout.parameter_count;
  const AdamNetworksArgs args{i.parameters.data(),
                              i.gradients.data(),
                              i.first.data(),
                              i.second.data(),
                              {options.beta1, options.beta2, options.network_epsilon},
                              numbers,
                              sums,
                              index,
                              std::uint32_t(begin),
                              std::uint32_t(end)};
  return i.device->launch(Kernel::adam_networks, args, end - begin);
}

float* DeviceField::point(int k) const { return impl_->axis(std::size_t(k)); }
std::int32_t* DeviceField::rows() const { return impl_->view.data(); }
float* DeviceField::sigma() const { return impl_->density.data(); }
float* DeviceField::colours() const { return impl_->colour.data(); }
float* DeviceField::d_sigma() const { return impl_->d_density.data(); }
float* DeviceField::d_colours() const { return impl_->d_colour.data(); }
float* DeviceField::codes() const { return impl_->codes.data(); }
float* DeviceField::d_codes() const { return impl_->d_codes.data(); }
std::uint32_t* DeviceField::count() const { return impl_->number.data(); }
float* DeviceField::gradients() const { return impl_->gradients.data(); }
std::size_t DeviceField::capacity() const { return impl_->options.capacity; }

}  // namespace likeness
