// Timing passes of the standard field: see field_speed.h.
#include "core/lab/bench/field_speed.h"

#include <algorithm>
#include <limits>
#include <memory>

#include "core/base/parallel.h"
#include "core/field/adam.h"
#include "core/field/evaluate.h"
#include "core/field/train_fields.h"
#include "core/lab/bench/ceiling_kernels.h"
#include "core/lab/bench/standard_field.h"
#include "core/lab/bench/stopwatch.h"

namespace likeness {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// The best times so far, seconds, of one precision.
struct BestTimes {
  double inference = kNever, training = kNever, passes = 0, adam_step = 0;
  std::size_t touched = 0;  // table lines a step of Adam moves
};

// A field trained on one batch, and a copy that is evaluated.
struct Timed {
  StandardBatch batch;
  Field evaluated, trained;
  std::shared_ptr<FieldTape> tape = make_tape();
  FieldGradients gradients;
  AdamState adam;
  FieldOutputs out;
  BestTimes single, bf16;

  Timed(const Field& start, std::size_t samples, std::uint32_t seed)
      : batch(standard_batch(start.config, samples, seed)),
        evaluated(start),
        trained(start),
        gradients(make_gradients(start, batch.views)),
        adam(make_adam_state(start)) {
    round_tables(evaluated);
  }
};

void time_inference(Timed& t, FieldPrecision precision, int threads, BestTimes& best) {
  const Stopwatch watch(threads);
  evaluate_field(t.evaluated, t.batch.inputs(), t.out, precision);
  best.inference = std::min(best.inference, watch.seconds());
}

void time_training(Timed& t, FieldPrecision precision, int threads, BestTimes& best) {
  AdamOptions options;
  options.table_rate = options.network_rate = 1e-6f;  // all of the work, but the field hardly changes
  const Stopwatch watch(threads);
  train_field(t.trained, t.batch.inputs(), t.out, t.batch.gradients(), *t.tape, t.gradients, precision);
  const double passes = watch.seconds();
  best.touched = std::size_t(std::count(t.gradients.touched.begin(), t.gradients.touched.end(), 1));
  const Stopwatch rest(threads);  // the count above is not part of a step
  adam_step(t.trained, t.gradients, t.adam, options);
  const double adam = rest.seconds();
  if (passes + adam >= best.training) return;
  best.training = passes + adam, best.passes = passes, best.adam_step = adam;
}

PassSpeed pass_speed(double seconds, std::size_t samples, double floor_seconds, double flops) {
  PassSpeed speed;
  const double each = seconds / double(samples);
  speed.ns_per_sample = 1e9 * each;
  speed.floor_ns_per_sample = 1e9 * floor_seconds;
  speed.fraction_of_floor = floor_seconds / each;
  speed.msamples_s = 1e-6 / each;
  speed.gflops = 1e-9 * flops / each;
  return speed;
}

StepSpeed step_speed(const BestTimes& best, std::size_t samples, FieldPrecision precision,
                     const FieldWork& work, const Ceilings& ceilings) {
  StepSpeed speed;
  speed.inference = pass_speed(best.inference, samples, forward_floor_seconds(work, ceilings, precision),
                               work.forward_flops);
  speed.training = pass_speed(best.training, samples, training_floor_seconds(work, ceilings, precision),
                              work.training_flops);
  const double ns = 1e9 / double(samples);
  speed.passes_ns = ns * best.passes, speed.adam_ns = ns * best.adam_step;
  // Value, gradient and two moments, each read and written.
  const double bytes = 8.0 * sizeof(float) * double(best.touched * kTableLine);
  speed.adam_floor_ns = ns * bytes / (1e9 * ceilings.bandwidth_gbs);
  return speed;
}

BatchSpeed batch_speed(const Timed& t, const FieldWork& work, const Ceilings& ceilings) {
  const std::size_t samples = t.batch.x.size();
  BatchSpeed speed;
  speed.samples = samples;
  speed.single = step_speed(t.single, samples, FieldPrecision::exact, work, ceilings);
  if (has_bf16(t.trained.config))
    speed.bf16 = step_speed(t.bf16, samples, FieldPrecision::bf16, work, ceilings);
  return speed;
}

// Processor time over wall time of a busy thread: 1 on an otherwise idle machine.
double measure_processor_share() {
  const Stopwatch own(1), wall(2);
  float keep = 0;
  while (wall.seconds() < 0.1) fma_block(1 << 12, keep);
  return std::min(1.0, own.seconds() / wall.seconds());
}

}  // namespace

Result<BenchReport> measure_field(const BenchOptions& options, const Progress& progress,
                                  std::stop_token stop) {
  BenchReport report;
  const Field field = standard_field(options.seed);
  report.work = field_work(field.config);
  const StandardBatch errors = standard_batch(field.config, options.error_samples, options.seed + 1);
  const bool bf16 = has_bf16(field.config);
  report.error = field_error(field, errors);
  if (bf16) report.bf16_error = field_error(field, errors, FieldPrecision::bf16);
  report.processor_share = measure_processor_share();

  double done = 0;
  const double all = double(options.threads.size()) * options.rounds;
  for (const int threads : options.threads) {
    const ThreadLimit limit(threads);
    std::vector<Timed> timed;
    for (const std::size_t samples : options.batches) timed.emplace_back(field, samples, options.seed + 2);
    ThreadSpeed speed;
    for (int round = 0; round < options.rounds; ++round, ++done) {
      if (stop.stop_requested()) return cancelled_error();
      progress.report(done / all, threads == 1 ? "1 thread" : std::to_string(threads) + " threads");
      const Ceilings ceilings = measure_ceilings(threads, options.ceiling_seconds);
      speed.ceilings = round == 0 ? ceilings : best_of(speed.ceilings, ceilings);
      for (Timed& t : timed) {
        time_inference(t, FieldPrecision::exact, threads, t.single);
        time_training(t, FieldPrecision::exact, threads, t.single);
        if (!bf16) continue;
        time_inference(t, FieldPrecision::bf16, threads, t.bf16);
        time_training(t, FieldPrecision::bf16, threads, t.bf16);
      }
    }
    for (const Timed& t : timed) speed.batches.push_back(batch_speed(t, report.work, speed.ceilings));
    report.threads.push_back(std::move(speed));
  }
  progress.report(1);
  return report;
}

}  // namespace likeness
