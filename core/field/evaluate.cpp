// The field on batches: shares the kernels' ranges among threads. See evaluate.h.
//
// Ranges whose results are summed have a fixed size and are summed in order, and every table level has one
// owner, so that results do not depend on the number of threads.
#include "core/field/evaluate.h"

#include <algorithm>
#include <memory>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/field/aligned_floats.h"
#include "core/field/conditioned_field.h"
#include "core/field/conditioned_parts.h"
#include "core/field/field_bf16.h"
#include "core/field/field_kernels.h"
#include "core/field/field_layout.h"
#include "core/field/rounded_tables.h"

namespace likeness {

void check_inputs(const Field& field, const FieldLayout& layout, const FieldInputs& inputs) {
  LIKENESS_CHECK(field.parameters.size() == layout.parameter_count, "%zu parameters for a field of %zu",
                 field.parameters.size(), layout.parameter_count);
  if (inputs.count == 0) return;
  LIKENESS_CHECK(inputs.x && inputs.y && inputs.z, "%zu samples without positions", inputs.count);
  LIKENESS_CHECK(inputs.conditions || field.config.condition_count == 0, "no conditions for a field of %d",
                 field.config.condition_count);
  LIKENESS_CHECK(inputs.local || field.config.local_conditions == 0, "no weights for %d local conditions",
                 field.config.local_conditions);
}

namespace {

// Samples for which a table level is used before the next one replaces it in the L2 cache: loading a table
// takes as long as reading it for some ten thousand samples.
constexpr std::size_t kEncodeChunk = 65536;

float* evaluation_scratch(std::size_t floats) {
  thread_local AlignedFloats scratch;
  return scratch.reserve(floats);
}

float* thread_features(std::size_t floats) {
  thread_local AlignedFloats features;
  return features.reserve(floats);
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
    const SampleRun run{begin, end, 0};
    encode_positions(context, {&run, 1}, evaluation_scratch(scratch), features);
    forward_tiles(context, {begin, end, features, slice, nullptr, evaluation_scratch(scratch), sigma, red,
                            green, blue, geometry});
  });
}

void evaluate(const Field& field, const FieldInputs& inputs, float* sigma, float* red, float* green,
              float* blue, float* geometry = nullptr) {
  const FieldLayout layout = make_layout(field.config);
  check_inputs(field, layout, inputs);
  evaluate({field.config, layout, field.parameters.data(), field.parameters.data(), inputs},
           encode_chunk(inputs.count), sigma, red, green, blue, geometry);
}

void evaluate_rounded(const Field& field, const FieldInputs& inputs, FieldOutputs& out) {
  const FieldLayout layout = make_layout(field.config);
  check_inputs(field, layout, inputs);
  const float* parameters = field.parameters.data();
  const std::shared_ptr<const RoundedTables> tables = tables_of(field, layout.table_count);
  const Bf16Parts parts{tables->values(),
                        exact_levels(field.config, layout),
                        pack_network(layout.density, parameters),
                        pack_network(layout.colour, parameters),
                        {}};
  evaluate({field.config, layout, parameters, parameters, inputs, &parts}, encode_chunk(inputs.count),
           out.sigma.data(), out.red.data(), out.green.data(), out.blue.data(), nullptr);
}

void evaluate(const KernelContext& context, std::size_t chunk, const GeometryFeatures& geometry,
              std::span<const std::uint32_t> chosen, FieldOutputs& out) {
  LIKENESS_CHECK(geometry.values.size() == context.inputs.count * geometry_stride(context.config),
                 "%zu geometry features for %zu samples", geometry.values.size(), context.inputs.count);
  for (std::vector<float>* array : {&out.red, &out.green, &out.blue}) array->resize(chosen.size());
  const std::size_t scratch = scratch_floats(context.config, context.layout);
  parallel_ranges(chosen.size(), chunk, [&](std::size_t begin, std::size_t end) {
    colour_tiles(context, {begin, end, chosen.data(), geometry.values.data(), evaluation_scratch(scratch),
                           out.red.data(), out.green.data(), out.blue.data()});
  });
}

// The samples of a picture's tile are close together, so tables stay in the cache anyway, and features too if
// they are few.
constexpr std::size_t kPictureChunk = 512;

// The picture's own conditions, the same for all samples except for their weights.
FieldInputs inputs_of(const ConditionedParts& parts, FieldInputs inputs) {
  LIKENESS_CHECK(inputs.local || parts.local.empty() || inputs.count == 0,
                 "no weights for %zu local conditions", parts.local.size());
  inputs.view = nullptr, inputs.latents = nullptr;
  inputs.conditions = parts.local.data();
  return inputs;
}

KernelContext context_of(const ConditionedParts& parts, const FieldInputs& inputs) {
  return {parts.config,          parts.layout, parts.tables,
          parts.networks.data(), inputs,       parts.bf16 ? &*parts.bf16 : nullptr};
}

void resize_outputs(FieldOutputs& out, std::size_t count) {
  for (std::vector<float>* array : {&out.sigma, &out.red, &out.green, &out.blue}) array->resize(count);
}

}  // namespace

void evaluate_field(const Field& field, const FieldInputs& inputs, FieldOutputs& out,
                    FieldPrecision precision) {
  resize_outputs(out, inputs.count);
  if (precision == FieldPrecision::bf16 && has_bf16(field.config))
    return evaluate_rounded(field, inputs, out);
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
  const FieldInputs own = inputs_of(field.parts(), inputs);
  evaluate(context_of(field.parts(), own), kPictureChunk, sigma.data(), nullptr, nullptr, nullptr, nullptr);
}

void evaluate_density(const ConditionedField& field, const FieldInputs& inputs, std::vector<float>& sigma,
                      GeometryFeatures& geometry) {
  const ConditionedParts& parts = field.parts();
  sigma.resize(inputs.count);
  geometry.values.resize(inputs.count * geometry_stride(parts.config));
  const FieldInputs own = inputs_of(parts, inputs);
  evaluate(context_of(parts, own), kPictureChunk, sigma.data(), nullptr, nullptr, nullptr,
           geometry.values.data());
}

void evaluate_colour(const ConditionedField& field, const FieldInputs& inputs,
                     const GeometryFeatures& geometry, std::span<const std::uint32_t> chosen,
                     FieldOutputs& out) {
  const FieldInputs own = inputs_of(field.parts(), inputs);
  evaluate(context_of(field.parts(), own), kPictureChunk, geometry, chosen, out);
}

}  // namespace likeness
