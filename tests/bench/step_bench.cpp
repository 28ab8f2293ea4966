// A step of training of the standard field, and a forward pass, by batch and threads. Items are samples; with
// one thread, its own processor time counts.
#include <benchmark/benchmark.h>

#include "core/base/parallel.h"
#include "core/bench/standard_field.h"
#include "core/field/adam.h"

namespace likeness {
namespace {

// Arguments: samples, threads.
struct Step {
  ThreadLimit limit;
  Field field = standard_field(1);
  StandardBatch batch;
  std::shared_ptr<FieldTape> tape = make_tape();
  FieldGradients gradients;
  AdamState adam = make_adam_state(field);
  AdamOptions options;
  FieldOutputs out;

  explicit Step(const benchmark::State& state)
      : limit(int(state.range(1))),
        batch(standard_batch(field.config, std::size_t(state.range(0)), 2)),
        gradients(make_gradients(field, batch.views)) {
    options.table_rate = options.network_rate = 1e-6f;  // the field stays where it is
  }
  void train() {
    train_field(field, batch.inputs(), out, batch.gradients(), *tape, gradients);
    adam_step(field, gradients, adam, options);
  }
};

void finish(benchmark::State& state) {
  state.SetItemsProcessed(std::int64_t(state.iterations()) * state.range(0));
}

void evaluate(benchmark::State& state) {
  Step step(state);
  evaluate_field(step.field, step.batch.inputs(), step.out);
  for (auto _ : state) evaluate_field(step.field, step.batch.inputs(), step.out);
  finish(state);
}

void train(benchmark::State& state) {
  Step step(state);
  step.train();  // its memory is there from now on
  for (auto _ : state) step.train();
  finish(state);
}

#define LIKENESS_SIZES ->ArgsProduct({{512, 4096, 32768, 131072}, {1, 2}})->Unit(benchmark::kMillisecond)
BENCHMARK(evaluate) LIKENESS_SIZES;
BENCHMARK(train) LIKENESS_SIZES;

}  // namespace
}  // namespace likeness

BENCHMARK_MAIN();
