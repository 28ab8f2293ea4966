// The field on batches: shares the kernels' ranges among threads. See evaluate.h.
//
// Ranges whose results are summed have a fixed size and are summed in order, and every table level has one
// owner, so that results do not depend on the number of threads.
#include "core/field/evaluate.h"

#include <algorithm>
#include <numeric>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/field/conditioned_field.h"
#include "core/field/conditioned_parts.h"
#include "core/field/field_kernels.h"
#include "core/field/field_layout.h"
#include "core/field/huge_pages.h"

namespace likeness {

struct FieldTape {
  std::size_t count = 0;  // samples of the last forward pass; 0: nothing to go back from
  AlignedFloats features, slice, kept, codes, partials;  // see field_kernels.h; partials: one block a chunk
};

namespace {

// Samples a table level is used for before the next one takes its place in the L2 cache: bringing the tables
// there takes as long as reading them for some ten thousand samples.
constexpr std::size_t kEncodeChunk = 65536;
// Samples that share one block of network gradients.
constexpr std::size_t kGradientChunk = 4096;

float* thread_scratch(std::size_t floats) {
  thread_local AlignedFloats scratch;
  return scratch.reserve(floats);
}

float* thread_features(std::size_t floats) {
  thread_local AlignedFloats features;
  return features.reserve(floats);
}

void check_inputs(const Field& field, const FieldLayout& layout, const FieldInputs& inputs) {
  LIKENESS_CHECK(field.parameters.size() == layout.parameter_count, "%zu parameters for a field of %zu",
                 field.parameters.size(), layout.parameter_count);
  if (inputs.count == 0) return;
  LIKENESS_CHECK(inputs.x && inputs.y && inputs.z, "%zu samples without positions", inputs.count);
  LIKENESS_CHECK(inputs.conditions || field.config.condition_count == 0, "no conditions for a field of %d",
                 field.config.condition_count);
}

// Every gradient array has its place, and every row that a sample points at exists.
void check_gradients(const Field& field, const FieldLayout& layout, const FieldInputs& inputs,
                     const FieldGradients& gradients) {
  LIKENESS_CHECK(gradients.parameters.size() == layout.parameter_count &&
                     gradients.touched.size() == layout.table_count / kTableLine,
                 "%zu gradients for %zu parameters", gradients.parameters.size(), layout.parameter_count);
  if (inputs.count == 0) return;
  std::int32_t first = 0, last = 0;
  if (inputs.view) {
    const auto [low, high] = std::minmax_element(inputs.view, inputs.view + inputs.count);
    first = *low, last = *high;
  }
  const std::size_t rows = std::size_t(last) + 1;
  LIKENESS_CHECK(first >= 0 && rows * std::size_t(field.config.latent_count) <= gradients.latents.size() &&
                     rows * std::size_t(field.config.condition_count) <= gradients.conditions.size(),
                 "views %d to %d, but gradients of %zu latents and %zu conditions", first, last,
                 gradients.latents.size(), gradients.conditions.size());
}

// Large enough for the cache, small enough that every thread gets a share.
std::size_t encode_chunk(std::size_t count) {
  const std::size_t share = count / std::size_t(std::max(1, current_thread_limit()));
  return std::clamp(tiles_of(share) * kTile, std::size_t{512}, kEncodeChunk);
}

// Inference: features live only as long as their chunk.
void evaluate(const KernelContext& context, std::size_t chunk, float* sigma, float* red, float* green,
              float* blue, float* geometry) {
  const std::size_t scratch = scratch_floats(context.config, context.layout);
  parallel_ranges(context.inputs.count, chunk, [&](std::size_t begin, std::size_t end) {
    const std::size_t samples = tiles_of(end - begin) * kTile;
    float* features = thread_features(
        samples * (context.density_inputs() + std::size_t(context.layout.ambient_dimensions)));
    float* slice = features + samples * context.density_inputs();
    forward_tiles(context, {begin, end, features, slice, nullptr, thread_scratch(scratch), sigma, red, green,
                            blue, geometry});
  });
}

void evaluate(const Field& field, const FieldInputs& inputs, float* sigma, float* red, float* green,
              float* blue, float* geometry = nullptr) {
  const FieldLayout layout = make_layout(field.config);
  check_inputs(field, layout, inputs);
  evaluate({field.config, layout, field.parameters.data(), field.parameters.data(), inputs},
           encode_chunk(inputs.count), sigma, red, green, blue, geometry);
}

void evaluate(const KernelContext& context, std::size_t chunk, const GeometryFeatures& geometry,
              std::span<const std::uint32_t> chosen, FieldOutputs& out) {
  LIKENESS_CHECK(geometry.values.size() == context.inputs.count * geometry_stride(context.config),
                 "%zu geometry features for %zu samples", geometry.values.size(), context.inputs.count);
  for (std::vector<float>* array : {&out.red, &out.green, &out.blue}) array->resize(chosen.size());
  const std::size_t scratch = scratch_floats(context.config, context.layout);
  parallel_ranges(chosen.size(), chunk, [&](std::size_t begin, std::size_t end) {
    colour_tiles(context, {begin, end, chosen.data(), geometry.values.data(), thread_scratch(scratch),
                           out.red.data(), out.green.data(), out.blue.data()});
  });
}

// The samples of a picture's tile lie together, so tables stay in the cache by themselves, and features too
// if they are few.
constexpr std::size_t kPictureChunk = 512;

KernelContext context_of(const ConditionedParts& parts, const FieldInputs& inputs) {
  return {parts.config,          parts.layout, parts.tables,
          parts.networks.data(), inputs,       parts.bf16 ? &*parts.bf16 : nullptr};
}

void resize_outputs(FieldOutputs& out, std::size_t count) {
  for (std::vector<float>* array : {&out.sigma, &out.red, &out.green, &out.blue}) array->resize(count);
}

// Adds the chunks' blocks, in order, to the gradients of one network.
void reduce_network(const std::vector<DenseLayer>& layers, const std::vector<PartialLayer>& partial_layers,
                    const float* partials, std::size_t stride, std::size_t chunks, float* gradients) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const DenseLayer& layer = layers[l];
    const PartialLayer& partial = partial_layers[l];
    parallel_ranges(std::size_t(layer.outputs), 8, [&](std::size_t begin, std::size_t end) {
      for (std::size_t o = begin; o < end; ++o) {
        float* row = gradients + layer.weights + o * std::size_t(layer.inputs);
        for (std::size_t k = 0; k < chunks; ++k) {
          const float* from = partials + k * stride + partial.weights + o * partial.stride;
          for (int i = 0; i < layer.inputs; ++i) row[i] += from[i];
          const float* lanes = partials + k * stride + partial.biases + o * kPartialLanes;
          gradients[layer.biases + o] += std::accumulate(lanes, lanes + kPartialLanes, 0.0f);
        }
      }
    });
  }
}

// table[view[n]][column] += row `column` of the tiles. Runs of one view, the samples of a ray, are added
// first.
void reduce_codes(const FieldInputs& inputs, const float* codes, std::size_t rows, std::size_t row,
                  float* table, std::size_t width, std::size_t column) {
  std::int32_t run = -1;
  float sum = 0;
  const auto flush = [&] {
    if (run >= 0) table[std::size_t(run) * width + column] += sum;
    sum = 0;
  };
  for (std::size_t n = 0; n < inputs.count; ++n) {
    const std::int32_t view = inputs.view ? inputs.view[n] : 0;
    if (view != run) flush(), run = view;
    sum += codes[(n / kTile * rows + row) * kTile + n % kTile];
  }
  flush();
}

void backward_networks(const KernelContext& context, const FieldOutputGradients& output_gradients,
                       FieldTape& tape, FieldGradients& gradients) {
  const FieldLayout& layout = context.layout;
  const PartialLayout partial = make_partial_layout(layout);
  const std::size_t count = context.inputs.count;
  const std::size_t chunks = (count + kGradientChunk - 1) / kGradientChunk;
  const std::size_t codes = context.code_rows(gradients.want_conditions);
  const std::size_t scratch = scratch_floats(context.config, layout);
  float* partials = tape.partials.reserve(chunks * partial.count);
  tape.codes.reserve(tiles_of(count) * kTile * codes);
  parallel_ranges(count, kGradientChunk, [&](std::size_t begin, std::size_t end) {
    float* sums = partials + begin / kGradientChunk * partial.count;
    std::fill(sums, sums + partial.count, 0.0f);
    BackwardRange range;
    range.begin = begin, range.end = end;
    range.features = tape.features.data() + begin * context.density_inputs();
    range.slice = tape.slice.data() + begin * std::size_t(layout.ambient_dimensions);
    range.kept = tape.kept.data() + begin * context.kept_rows();
    range.scratch = thread_scratch(scratch);
    range.gradients = output_gradients;
    range.want_conditions = gradients.want_conditions;
    range.codes = tape.codes.data() + begin * codes;
    range.partial = sums, range.partial_layout = &partial;
    backward_tiles(context, range);
  });
  float* g = gradients.parameters.data();
  reduce_network(layout.slice, partial.slice, partials, partial.count, chunks, g);
  reduce_network(layout.density, partial.density, partials, partial.count, chunks, g);
  reduce_network(layout.colour, partial.colour, partials, partial.count, chunks, g);
}

}  // namespace

std::shared_ptr<FieldTape> make_tape() { return std::make_shared<FieldTape>(); }

FieldGradients make_gradients(const Field& field, std::size_t views) {
  const FieldLayout layout = make_layout(field.config);
  FieldGradients gradients;
  gradients.parameters = large_array(layout.parameter_count);
  gradients.touched.assign(layout.table_count / kTableLine, 0);
  gradients.latents.assign(views * std::size_t(field.config.latent_count), 0.0f);
  gradients.conditions.assign(views * std::size_t(field.config.condition_count), 0.0f);
  return gradients;
}

void clear_gradients(FieldGradients& gradients) {
  for (std::vector<float>* array : {&gradients.parameters, &gradients.latents, &gradients.conditions}) {
    std::fill(array->begin(), array->end(), 0.0f);
  }
  std::fill(gradients.touched.begin(), gradients.touched.end(), std::uint8_t{0});
}

void evaluate_field(const Field& field, const FieldInputs& inputs, FieldOutputs& out) {
  resize_outputs(out, inputs.count);
  evaluate(field, inputs, out.sigma.data(), out.red.data(), out.green.data(), out.blue.data());
}

void evaluate_density(const Field& field, const FieldInputs& inputs, std::vector<float>& sigma) {
  sigma.resize(inputs.count);
  evaluate(field, inputs, sigma.data(), nullptr, nullptr, nullptr);
}

void evaluate_density(const Field& field, const FieldInputs& inputs, std::vector<float>& sigma,
                      GeometryFeatures& geometry) {
  sigma.resize(inputs.count);
  geometry.values.resize(inputs.count * geometry_stride(field.config));
  evaluate(field, inputs, sigma.data(), nullptr, nullptr, nullptr, geometry.values.data());
}

void evaluate_colour(const Field& field, const FieldInputs& inputs, const GeometryFeatures& geometry,
                     std::span<const std::uint32_t> chosen, FieldOutputs& out) {
  const FieldLayout layout = make_layout(field.config);
  check_inputs(field, layout, inputs);
  evaluate({field.config, layout, field.parameters.data(), field.parameters.data(), inputs},
           encode_chunk(chosen.size()), geometry, chosen, out);
}

void evaluate_density(const ConditionedField& field, const FieldInputs& inputs, std::vector<float>& sigma) {
  sigma.resize(inputs.count);
  evaluate(context_of(field.parts(), inputs), kPictureChunk, sigma.data(), nullptr, nullptr, nullptr,
           nullptr);
}

void evaluate_density(const ConditionedField& field, const FieldInputs& inputs, std::vector<float>& sigma,
                      GeometryFeatures& geometry) {
  const ConditionedParts& parts = field.parts();
  sigma.resize(inputs.count);
  geometry.values.resize(inputs.count * geometry_stride(parts.config));
  evaluate(context_of(parts, inputs), kPictureChunk, sigma.data(), nullptr, nullptr, nullptr,
           geometry.values.data());
}

void evaluate_colour(const ConditionedField& field, const FieldInputs& inputs,
                     const GeometryFeatures& geometry, std::span<const std::uint32_t> chosen,
                     FieldOutputs& out) {
  evaluate(context_of(field.parts(), inputs), kPictureChunk, geometry, chosen, out);
}

void forward_field(const Field& field, const FieldInputs& inputs, FieldOutputs& out, FieldTape& tape) {
  const FieldLayout layout = make_layout(field.config);
  check_inputs(field, layout, inputs);
  resize_outputs(out, inputs.count);
  const KernelContext context{field.config, layout, field.parameters.data(), field.parameters.data(), inputs};
  const std::size_t samples = tiles_of(inputs.count) * kTile;
  const std::size_t dimensions = std::size_t(layout.ambient_dimensions);
  const std::size_t scratch = scratch_floats(field.config, layout);
  float* features = tape.features.reserve(samples * context.density_inputs());
  float* slice = tape.slice.reserve(samples * std::max<std::size_t>(dimensions, 1));
  float* kept = tape.kept.reserve(samples * context.kept_rows());
  tape.count = inputs.count;
  parallel_ranges(inputs.count, encode_chunk(inputs.count), [&](std::size_t begin, std::size_t end) {
    forward_tiles(context,
                  {begin, end, features + begin * context.density_inputs(), slice + begin * dimensions,
                   kept + begin * context.kept_rows(), thread_scratch(scratch), out.sigma.data(),
                   out.red.data(), out.green.data(), out.blue.data()});
  });
}

void backward_field(const Field& field, const FieldInputs& inputs,
                    const FieldOutputGradients& output_gradients, FieldTape& tape,
                    FieldGradients& gradients) {
  const FieldLayout layout = make_layout(field.config);
  check_inputs(field, layout, inputs);
  LIKENESS_CHECK(tape.count == inputs.count, "the tape holds %zu samples, the inputs %zu", tape.count,
                 inputs.count);
  check_gradients(field, layout, inputs, gradients);
  tape.count = 0;
  if (gradients.want_positions) {
    for (std::vector<float>* array : {&gradients.x, &gradients.y, &gradients.z}) array->resize(inputs.count);
  }
  if (inputs.count == 0) return;
  const KernelContext context{field.config, layout, field.parameters.data(), field.parameters.data(), inputs};
  backward_networks(context, output_gradients, tape, gradients);

  // -- Tables and codes: every level and every entry of a code has one owner.
  const std::size_t levels = layout.position.size(), tables = levels + layout.ambient.size();
  const std::size_t codes = context.code_rows(gradients.want_conditions);
  const std::size_t latents = std::size_t(field.config.latent_count);
  parallel_for(tables + codes, [&](std::size_t task) {
    if (task < tables) {
      const bool ambient = task >= levels;
      scatter_level(context, ambient, int(ambient ? task - levels : task), tape.features.data(),
                    tape.slice.data(), gradients.parameters.data(), gradients.touched.data());
      return;
    }
    const std::size_t row = task - tables;
    if (row < latents) {
      if (inputs.latents) {
        reduce_codes(inputs, tape.codes.data(), codes, row, gradients.latents.data(), latents, row);
      }
    } else {
      reduce_codes(inputs, tape.codes.data(), codes, row, gradients.conditions.data(),
                   std::size_t(field.config.condition_count), row - latents);
    }
  });
  if (gradients.want_positions) {
    parallel_ranges(inputs.count, kGradientChunk, [&](std::size_t begin, std::size_t end) {
      position_gradients(context, begin, end, tape.features.data(), gradients.x.data(), gradients.y.data(),
                         gradients.z.data());
    });
  }
}

}  // namespace likeness
