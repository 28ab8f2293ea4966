// What each arrangement of the field's kernels brings, on the standard field: rows to be compared stand
// together. Items are samples.
#include <benchmark/benchmark.h>

#include <algorithm>

#include "core/field/aligned_floats.h"
#include "core/field/field_kernels.h"
#include "core/field/train_fields.h"
#include "core/lab/bench/standard_field.h"
#include "tests/bench/field_variants.h"

namespace likeness {
namespace {

constexpr std::size_t kSamples = 65536;
constexpr int kDenseLevel = 3, kHashedLevel = 12;

struct Tables {
  Field field = standard_field(1);
  FieldLayout layout = make_layout(field.config);
  StandardBatch batch = standard_batch(field.config, kSamples, 2);
  FieldGradients gradients = make_gradients(field, batch.views);
  AlignedFloats memory;
  float* rows = memory.reserve(kSamples * 2 * layout.position.size());

  Tables() { std::fill(rows, rows + kSamples * 2 * layout.position.size(), 1e-3f); }
  TableCase table_case() const {
    return {field.config,
            layout,
            field.parameters.data(),
            {batch.x.data(), batch.y.data(), batch.z.data()},
            kSamples};
  }
};

void finish(benchmark::State& state, std::size_t samples) {
  state.SetItemsProcessed(std::int64_t(state.iterations()) * std::int64_t(samples));
}

void read(benchmark::State& state, int level, Read how) {
  Tables t;
  for (auto _ : state) read_level(t.table_case(), level, how, t.rows);
  finish(state, kSamples);
}
BENCHMARK_CAPTURE(read, dense_scalar, kDenseLevel, Read::scalar);
BENCHMARK_CAPTURE(read, dense_pairs, kDenseLevel, Read::pairs);
BENCHMARK_CAPTURE(read, dense_neighbours, kDenseLevel, Read::neighbours);
BENCHMARK_CAPTURE(read, hashed_scalar, kHashedLevel, Read::scalar);
BENCHMARK_CAPTURE(read, hashed_pairs, kHashedLevel, Read::pairs);

void read_in_chunks(benchmark::State& state) {
  Tables t;
  for (auto _ : state) read_levels(t.table_case(), std::size_t(state.range(0)), t.rows);
  finish(state, kSamples);
}
BENCHMARK(read_in_chunks)->Arg(16384)->Arg(65536);

// The largest levels in turn, so that rows come from memory as in a step.
void update(benchmark::State& state, int first, int last, Update how) {
  Tables t;
  for (auto _ : state) {
    for (int level = first; level <= last; ++level)
      update_level(t.table_case(), level, how, t.rows, t.gradients.parameters.data(),
                   t.gradients.touched.data());
  }
  state.SetItemsProcessed(std::int64_t(state.iterations()) * std::int64_t(kSamples) * (last - first + 1));
}
BENCHMARK_CAPTURE(update, hashed_marking, 8, 15, Update::marking);
BENCHMARK_CAPTURE(update, hashed_in_order, 8, 15, Update::in_order);
BENCHMARK_CAPTURE(update, hashed_apart, 8, 15, Update::apart);
BENCHMARK_CAPTURE(update, hashed_ahead, 8, 15, Update::ahead);
BENCHMARK_CAPTURE(update, dense_in_order, 0, kDenseLevel, Update::in_order);
BENCHMARK_CAPTURE(update, dense_apart, 0, kDenseLevel, Update::apart);
BENCHMARK_CAPTURE(update, dense_ahead, 0, kDenseLevel, Update::ahead);

}  // namespace
}  // namespace likeness

BENCHMARK_MAIN();
