// The fast path against the double reference: see field_error.h.
#include "core/lab/bench/field_error.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/field/adam.h"
#include "core/field/field_reference.h"
#include "core/field/train_fields.h"
#include "core/lab/bench/relative_l2.h"

namespace likeness {
namespace {

constexpr double kMargin = 1e-4;

// Adam's first step in double, of table or network parameters: value - change.
double first_step(double gradient, const AdamOptions& options, bool table) {
  const double rate = table ? options.table_rate : options.network_rate;
  const double epsilon = table ? options.table_epsilon : options.network_epsilon;
  const double beta1 = options.beta1, beta2 = options.beta2;
  const double corrected = rate * std::sqrt(1 - beta2) / (1 - beta1);
  return corrected * (1 - beta1) * gradient / (std::sqrt((1 - beta2) * gradient * gradient) + epsilon);
}

double adam_error(const Field& field, FieldGradients gradients) {
  AdamState state = make_adam_state(field);
  AdamOptions options;
  options.table_rate = options.network_rate = 1;  // so that the change is not lost in the value's rounding
  Field after = field;
  const std::vector<float> given = gradients.parameters;
  adam_step(after, gradients, state, options);
  double worst = 0;
  for (const ParameterBlock& block : parameter_layout(field.config)) {
    std::vector<float> values;
    std::vector<double> truths;
    for (std::size_t i = block.offset; i < block.offset + block.count; ++i) {
      values.push_back(after.parameters[i]);
      truths.push_back(double(field.parameters[i]) - first_step(given[i], options, block.table));
    }
    worst = std::max(worst, relative_l2(values, truths));
  }
  return worst;
}

}  // namespace

FieldError field_error(const Field& field, const StandardBatch& given, FieldPrecision precision) {
  StandardBatch batch = given;
  const std::vector<double> parameters(field.parameters.begin(), field.parameters.end());
  const auto samples = reference_samples<double>(field.config, batch.inputs(), batch.views);
  FieldError error;
  const std::vector<double> margin = reference_margin<double>(field.config, parameters, samples);
  for (std::size_t n = 0; n < margin.size(); ++n) {
    if (margin[n] > kMargin) continue;
    batch.sigma[n] = batch.red[n] = batch.green[n] = batch.blue[n] = 0;
    ++error.left_out;
  }
  const auto truth = reference_forward<double>(field.config, parameters, samples);
  const auto slopes = reference_backward<double>(field.config, parameters, samples,
                                                 {{batch.sigma.begin(), batch.sigma.end()},
                                                  {batch.red.begin(), batch.red.end()},
                                                  {batch.green.begin(), batch.green.end()},
                                                  {batch.blue.begin(), batch.blue.end()}});
  FieldGradients gradients = make_gradients(field, batch.views);
  const std::shared_ptr<FieldTape> tape = make_tape();
  FieldOutputs out;
  train_field(field, batch.inputs(), out, batch.gradients(), *tape, gradients, precision);
  error.outputs = std::max({relative_l2(out.sigma, truth.sigma), relative_l2(out.red, truth.red),
                            relative_l2(out.green, truth.green), relative_l2(out.blue, truth.blue)});
  for (const ParameterBlock& block : parameter_layout(field.config)) {
    double& worst = block.table ? error.tables : error.networks;
    worst = std::max(worst, relative_l2(std::span(gradients.parameters).subspan(block.offset, block.count),
                                        std::span(slopes.parameters).subspan(block.offset, block.count)));
  }
  error.adam = adam_error(field, std::move(gradients));
  return error;
}

}  // namespace likeness
