// A step of training of the standard field, and a forward pass, by batch and threads, in single precision and
// in bfloat16 in turn: the best of each, ns a sample, and how many times as fast bfloat16 is; and one step in
// blocks of several sizes, the last a whole batch, whose forward pass ends before the first sample goes back.
// Items are samples a second of processor time, of both precisions together.
#include <algorithm>
#include <limits>

#include <benchmark/benchmark.h>

#include "core/base/parallel.h"
#include "core/field/adam.h"
#include "core/field/evaluate.h"
#include "core/lab/bench/standard_field.h"
#include "core/lab/bench/stopwatch.h"

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
  void train(FieldPrecision precision) {
    train_field(field, batch.inputs(), out, batch.gradients(), *tape, gradients, precision);
    adam_step(field, gradients, adam, options);
  }
};

// Both precisions' best times in turn.
template <class Work>
void in_turn(benchmark::State& state, const Work& work) {
  constexpr FieldPrecision kBoth[2] = {FieldPrecision::exact, FieldPrecision::bf16};
  double best[2] = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (const FieldPrecision precision : kBoth) work(precision);  // its memory is there from now on
  for (auto _ : state)
    for (int k = 0; k < 2; ++k) {
      const Stopwatch watch(int(state.range(1)));
      work(kBoth[k]);
      best[k] = std::min(best[k], watch.seconds());
    }
  const double samples = double(state.range(0));
  state.counters["single_ns"] = 1e9 * best[0] / samples;
  state.counters["bf16_ns"] = 1e9 * best[1] / samples;
  state.counters["times"] = best[0] / best[1];
  state.SetItemsProcessed(2 * std::int64_t(state.iterations()) * state.range(0));
}

void evaluate(benchmark::State& state) {
  Step step(state);
  round_tables(step.field);
  in_turn(state, [&](FieldPrecision precision) {
    evaluate_field(step.field, step.batch.inputs(), step.out, precision);
  });
}

void train(benchmark::State& state) {
  Step step(state);
  in_turn(state, [&](FieldPrecision precision) { step.train(precision); });
}

// Arguments: samples, threads, samples of a block.
void train_in_blocks(benchmark::State& state) {
  Step step(state);
  std::vector<std::size_t> ends;
  for (std::size_t end = std::size_t(state.range(2)); end <= step.batch.x.size();
       end += std::size_t(state.range(2)))
    ends.push_back(end);
  const FieldStep pass{step.field, step.batch.inputs(), ends, step.out, step.batch.gradients(),
                       *step.tape, step.gradients};
  const auto train = [&] {
    train_fields({&pass, 1}, nullptr);
    adam_step(step.field, step.gradients, step.adam, step.options);
  };
  train();
  for (auto _ : state) train();
  state.SetItemsProcessed(std::int64_t(state.iterations()) * state.range(0));
}

#define LIKENESS_SIZES ->ArgsProduct({{32768, 131072}, {1, 2}})->Unit(benchmark::kMillisecond)
BENCHMARK(evaluate) LIKENESS_SIZES;
BENCHMARK(train) LIKENESS_SIZES;
BENCHMARK(train_in_blocks)->ArgsProduct({{131072}, {1}, {256, 4096, 131072}})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace likeness

BENCHMARK_MAIN();
