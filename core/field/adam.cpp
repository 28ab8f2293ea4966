// Adam on a field: see adam.h.
#include "core/field/adam.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/field/field_kernels.h"
#include "core/field/field_layout.h"
#include "core/field/huge_pages.h"

namespace likeness {
namespace {

// Learning rate with both bias corrections folded in: sqrt(1 - beta2^t) / (1 - beta1^t). Epsilon is thus
// added to the uncorrected root of the second moment, as in section 2 of the paper.
float corrected_rate(float rate, const AdamOptions& options, std::uint64_t step) {
  const double t = double(step);
  return float(rate * std::sqrt(1 - std::pow(double(options.beta2), t)) /
               (1 - std::pow(double(options.beta1), t)));
}

void step_tables(Field& field, FieldGradients& gradients, AdamState& state, const AdamOptions& options) {
  // The correction is 1 to float precision long before this many steps.
  constexpr std::uint32_t kSettled = 4096;
  std::vector<float> rates(kSettled + 1);
  double power1 = 1, power2 = 1;
  for (float& rate : rates) {
    rate = power1 < 1 ? float(options.table_rate * std::sqrt(1 - power2) / (1 - power1)) : 0.0f;
    power1 *= options.beta1, power2 *= options.beta2;
  }
  parallel_ranges(gradients.touched.size(), 4096, [&](std::size_t begin, std::size_t end) {
    const auto age = [&](std::size_t line) { return std::min(state.line_steps[line], kSettled); };
    for (std::size_t line = begin; line < end;) {
      if (!gradients.touched[line]) {
        ++line;
        continue;
      }
      // Neighbouring lines of the same age share one update.
      std::size_t stop = line;
      for (; stop < end && gradients.touched[stop] && (stop == line || age(stop) + 1 == age(line)); ++stop) {
        gradients.touched[stop] = 0;
        ++state.line_steps[stop];
      }
      const std::size_t i = line * kTableLine;
      adam_update(
          &field.parameters[i], &gradients.parameters[i], &state.first[i], &state.second[i],
          (stop - line) * kTableLine,
          {rates[age(line)], options.beta1, options.beta2, options.table_epsilon, 0, options.table_keep()});
      line = stop;
    }
  });
}

}  // namespace

AdamState make_adam_state(const Field& field) {
  const std::size_t count = field.parameters.size();
  return {large_array(count), large_array(count),
          std::vector<std::uint32_t>(make_layout(field.config).table_count / kTableLine, 0u), 0};
}

void adam_step(Field& field, FieldGradients& gradients, AdamState& state, const AdamOptions& options) {
  const std::size_t count = field.parameters.size();
  LIKENESS_CHECK(gradients.parameters.size() == count && state.first.size() == count &&
                     state.second.size() == count && state.line_steps.size() == gradients.touched.size(),
                 "%zu parameters, %zu gradients, %zu moments", count, gradients.parameters.size(),
                 state.first.size());
  ++state.step;
  step_tables(field, gradients, state, options);
  const float rate = corrected_rate(options.network_rate, options, state.step);
  for (const ParameterBlock& block : parameter_layout(field.config)) {
    if (block.table) continue;
    const float l2 = block.rows > 0 ? options.network_l2 : 0.0f;  // weights, not biases
    const std::size_t i = block.offset;
    adam_update(&field.parameters[i], &gradients.parameters[i], &state.first[i], &state.second[i],
                block.count, {rate, options.beta1, options.beta2, options.network_epsilon, l2});
  }
}

void adam_step(std::vector<float>& values, std::vector<float>& gradients, ArrayAdamState& state, float rate,
               const AdamOptions& options) {
  LIKENESS_CHECK(values.size() == gradients.size(), "%zu values, %zu gradients", values.size(),
                 gradients.size());
  state.first.resize(values.size(), 0.0f);
  state.second.resize(values.size(), 0.0f);
  ++state.step;
  adam_update(
      values.data(), gradients.data(), state.first.data(), state.second.data(), values.size(),
      {corrected_rate(rate, options, state.step), options.beta1, options.beta2, options.network_epsilon, 0});
}

}  // namespace likeness
