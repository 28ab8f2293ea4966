// Speed of the field's passes, fast path against reference. Items are samples; CPU time counts all threads.
#include <benchmark/benchmark.h>

#include "core/base/parallel.h"
#include "core/field/adam.h"
#include "core/field/evaluate.h"
#include "core/field/field_reference.h"
#include "core/field/train_fields.h"
#include "tests/core/field/random_field.h"

namespace likeness {
namespace {

constexpr std::size_t kBatch = 131072;

FieldConfig bench_config() {
  FieldConfig config;
  config.condition_count = 6;
  config.latent_count = 8;
  return config;
}

// Samples along rays, as in training: 16 in a row share a view and a direction.
Batch ray_batch(const FieldConfig& config, std::size_t count) {
  Batch batch = random_batch(config, count, 64, 1);
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t ray = n / 16 * 16;
    const float t = float(n - ray) / 32;
    batch.x[n] = 0.5f * batch.x[ray] + t * std::abs(batch.dx[ray]);
    batch.y[n] = 0.5f * batch.y[ray] + t * std::abs(batch.dy[ray]);
    batch.z[n] = 0.5f * batch.z[ray] + t * std::abs(batch.dz[ray]);
    batch.dx[n] = batch.dx[ray], batch.dy[n] = batch.dy[ray], batch.dz[n] = batch.dz[ray];
    batch.view[n] = batch.view[ray];
  }
  return batch;
}

// Argument: threads.
void finish(benchmark::State& state, std::size_t samples) {
  state.SetItemsProcessed(std::int64_t(state.iterations()) * std::int64_t(samples));
}

void evaluate(benchmark::State& state) {
  const ThreadLimit limit(int(state.range(0)));
  const Field field = trained_like_field(bench_config(), 1);
  const Batch batch = ray_batch(field.config, kBatch);
  FieldOutputs out;
  for (auto _ : state) evaluate_field(field, batch.inputs(), out);
  finish(state, kBatch);
}
BENCHMARK(evaluate)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

void density(benchmark::State& state) {
  const ThreadLimit limit(int(state.range(0)));
  const Field field = trained_like_field(bench_config(), 1);
  const Batch batch = ray_batch(field.config, kBatch);
  std::vector<float> sigma;
  for (auto _ : state) evaluate_density(field, batch.inputs(), sigma);
  finish(state, kBatch);
}
BENCHMARK(density)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

struct Training {
  Field field = trained_like_field(bench_config(), 1);
  Batch batch = ray_batch(field.config, kBatch);
  std::shared_ptr<FieldTape> tape = make_tape();
  FieldGradients gradients = make_gradients(field, 64);
  AdamState adam = make_adam_state(field);
  FieldOutputs out;
};

void train(benchmark::State& state) {
  const ThreadLimit limit(int(state.range(0)));
  Training t;
  AdamOptions options;
  options.table_rate = options.network_rate = 1e-6f;  // the field stays where it is
  const auto step = [&] {
    train_field(t.field, t.batch.inputs(), t.out, t.batch.output_gradients(), *t.tape, t.gradients);
    adam_step(t.field, t.gradients, t.adam, options);
  };
  step();  // its memory is there from now on
  for (auto _ : state) step();
  finish(state, kBatch);
}
BENCHMARK(train)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

void adam(benchmark::State& state) {
  const ThreadLimit limit(int(state.range(0)));
  Training t;
  const std::vector<std::uint8_t> all(t.gradients.touched.size(), 1);
  for (auto _ : state) {
    t.gradients.touched = all;
    adam_step(t.field, t.gradients, t.adam, {});
  }
  finish(state, kBatch);
}
BENCHMARK(adam)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

void reference_evaluate(benchmark::State& state) {
  const Field field = trained_like_field(bench_config(), 1);
  const Batch batch = ray_batch(field.config, 4096);
  const auto samples = reference_samples<float>(field.config, batch.inputs(), batch.views);
  for (auto _ : state)
    benchmark::DoNotOptimize(reference_forward<float>(field.config, field.parameters, samples));
  finish(state, 4096);
}
BENCHMARK(reference_evaluate)->Unit(benchmark::kMillisecond);

void reference_train(benchmark::State& state) {
  const Field field = trained_like_field(bench_config(), 1);
  const Batch batch = ray_batch(field.config, 4096);
  const auto samples = reference_samples<float>(field.config, batch.inputs(), batch.views);
  const ReferenceOutputs<float> gradients{batch.sigma, batch.red, batch.green, batch.blue};
  for (auto _ : state) {
    benchmark::DoNotOptimize(reference_backward<float>(field.config, field.parameters, samples, gradients));
  }
  finish(state, 4096);
}
BENCHMARK(reference_train)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace likeness

BENCHMARK_MAIN();
