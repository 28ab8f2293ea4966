// The field on batches, through the reference: see evaluate.h.
#include "core/field/evaluate.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/field/field_layout.h"
#include "core/field/field_reference.h"

namespace likeness {

struct FieldTape {
  std::size_t count = 0;
};

std::shared_ptr<FieldTape> make_tape() { return std::make_shared<FieldTape>(); }

FieldGradients make_gradients(const Field& field, std::size_t views) {
  const FieldLayout layout = make_layout(field.config);
  FieldGradients gradients;
  gradients.parameters.assign(layout.parameter_count, 0.0f);
  gradients.touched.assign(layout.table_count / kTableLine, 0);
  gradients.latents.assign(views * field.config.latent_count, 0.0f);
  gradients.conditions.assign(views * field.config.condition_count, 0.0f);
  return gradients;
}

void clear_gradients(FieldGradients& gradients) {
  for (std::vector<float>* array : {&gradients.parameters, &gradients.latents, &gradients.conditions}) {
    std::fill(array->begin(), array->end(), 0.0f);
  }
  std::fill(gradients.touched.begin(), gradients.touched.end(), std::uint8_t{0});
}

static std::size_t view_count(const FieldInputs& inputs) {
  if (!inputs.view || inputs.count == 0) return 1;
  return std::size_t(*std::max_element(inputs.view, inputs.view + inputs.count)) + 1;
}

void evaluate_field(const Field& field, const FieldInputs& inputs, FieldOutputs& out) {
  const auto samples = reference_samples<float>(field.config, inputs, view_count(inputs));
  ReferenceOutputs<float> r = reference_forward<float>(field.config, field.parameters, samples);
  out = {std::move(r.sigma), std::move(r.red), std::move(r.green), std::move(r.blue)};
}

void evaluate_density(const Field& field, const FieldInputs& inputs, std::vector<float>& sigma) {
  FieldOutputs out;
  evaluate_field(field, inputs, out);
  sigma = std::move(out.sigma);
}

void forward_field(const Field& field, const FieldInputs& inputs, FieldOutputs& out, FieldTape& tape) {
  tape.count = inputs.count;
  evaluate_field(field, inputs, out);
}

void backward_field(const Field& field, const FieldInputs& inputs,
                    const FieldOutputGradients& output_gradients, FieldTape& tape,
                    FieldGradients& gradients) {
  LIKENESS_CHECK(tape.count == inputs.count, "tape of %zu samples, inputs of %zu", tape.count, inputs.count);
  const auto samples = reference_samples<float>(field.config, inputs, view_count(inputs));
  const std::size_t n = inputs.count;
  ReferenceOutputs<float> og;
  og.sigma.assign(output_gradients.sigma, output_gradients.sigma + n);
  og.red.assign(output_gradients.red, output_gradients.red + n);
  og.green.assign(output_gradients.green, output_gradients.green + n);
  og.blue.assign(output_gradients.blue, output_gradients.blue + n);
  const auto r = reference_backward<float>(field.config, field.parameters, samples, og);
  for (std::size_t i = 0; i < r.parameters.size(); ++i) {
    gradients.parameters[i] += r.parameters[i];
    if (r.parameters[i] != 0 && i / kTableLine < gradients.touched.size())
      gradients.touched[i / kTableLine] = 1;
  }
  for (std::size_t i = 0; i < r.latents.size(); ++i) gradients.latents[i] += r.latents[i];
  if (gradients.want_conditions) {
    for (std::size_t i = 0; i < r.conditions.size(); ++i) gradients.conditions[i] += r.conditions[i];
  }
  if (gradients.want_positions) gradients.x = r.x, gradients.y = r.y, gradients.z = r.z;
}

}  // namespace likeness
