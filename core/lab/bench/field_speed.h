// Timing the standard field beside the ceilings, in one run: what `likeness bench` reports.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/lab/bench/ceilings.h"
#include "core/lab/bench/field_error.h"
#include "core/lab/bench/field_work.h"

namespace likeness {

struct BenchOptions {
  std::vector<int> threads = {1};                      // each is measured by itself
  std::vector<std::size_t> batches = {32768, 131072};  // samples
  int rounds = 7;                                      // ceilings and field in turn; the best of each counts
  double ceiling_seconds = 0.01;                       // for each figure in each round
  std::size_t error_samples = 1024;
  std::uint32_t seed = 1;
};

// One pass over a batch.
struct PassSpeed {
  double ns_per_sample = 0, floor_ns_per_sample = 0;
  double fraction_of_floor = 0;  // floor / measured: 1 is as fast as the ceilings allow
  double msamples_s = 0, gflops = 0;
};

// A step of training is the passes, forward and backward in turn, and Adam, timed within the same steps.
struct StepSpeed {
  PassSpeed inference, training;
  // Of the best step, ns a sample; Adam's floor is its bytes through the memory's bandwidth, less where the
  // tables stay in a cache.
  double passes_ns = 0, adam_ns = 0, adam_floor_ns = 0;
};

struct BatchSpeed {
  std::size_t samples = 0;
  StepSpeed single;
  std::optional<StepSpeed> bf16;  // where the processor has it; inference of tables that are already rounded
};

struct ThreadSpeed {
  Ceilings ceilings;
  std::vector<BatchSpeed> batches;
};

struct BenchReport {
  FieldWork work;
  std::vector<ThreadSpeed> threads;
  FieldError error;
  std::optional<FieldError> bf16_error;
  double processor_share = 1;  // of the wall clock that one busy thread got; under 0.9 others use the machine
};

Result<BenchReport> measure_field(const BenchOptions& options, const Progress& progress,
                                  std::stop_token stop);

}  // namespace likeness
