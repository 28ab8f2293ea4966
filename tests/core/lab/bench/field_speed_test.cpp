// Claims about core/lab/bench/field_speed.h. No claim about a time: this machine may be doing anything else.
#include "core/lab/bench/field_speed.h"

#include <cmath>
#include <mutex>

#include <gtest/gtest.h>

namespace likeness {
namespace {

BenchOptions quick() {
  BenchOptions options;
  options.threads = {1, 2};
  options.batches = {512, 2048};
  options.rounds = 2;
  options.ceiling_seconds = 1e-3;
  options.error_samples = 64;
  return options;
}

void expect_consistent(const PassSpeed& s) {
  for (const double v : {s.ns_per_sample, s.floor_ns_per_sample, s.fraction_of_floor, s.msamples_s, s.gflops})
    EXPECT_TRUE(std::isfinite(v) && v > 0) << v;
  EXPECT_NEAR(s.fraction_of_floor, s.floor_ns_per_sample / s.ns_per_sample, 1e-9);
  EXPECT_NEAR(s.msamples_s * s.ns_per_sample, 1e3, 1e-6);
}

void expect_consistent(const StepSpeed& s) {
  expect_consistent(s.inference);
  expect_consistent(s.training);
  EXPECT_GT(s.training.floor_ns_per_sample, s.inference.floor_ns_per_sample);
  EXPECT_NEAR(s.passes_ns + s.adam_ns, s.training.ns_per_sample, 1e-3);
  EXPECT_GT(s.adam_floor_ns, 0);
}

TEST(FieldSpeed, GivesEveryBatchAndThreadCountFiguresThatAgree) {
  double last = -1;
  std::mutex guard;
  const Progress progress([&](const ProgressReport& r) {
    const std::lock_guard lock(guard);
    EXPECT_GE(r.fraction, last);
    last = r.fraction;
  });
  const Result<BenchReport> report = measure_field(quick(), progress, {});
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(last, 1);
  ASSERT_EQ(report->threads.size(), 2u);
  for (std::size_t t = 0; t < 2; ++t) {
    EXPECT_EQ(report->threads[t].ceilings.threads, int(t) + 1);
    ASSERT_EQ(report->threads[t].batches.size(), 2u);
    for (const BatchSpeed& b : report->threads[t].batches) {
      expect_consistent(b.single);
      ASSERT_EQ(b.bf16.has_value(), report->bf16_error.has_value());
      if (!b.bf16) continue;
      expect_consistent(*b.bf16);
    }
  }
  EXPECT_GT(report->processor_share, 0);
  EXPECT_LE(report->processor_share, 1);
}

TEST(FieldSpeed, StopsOnRequest) {
  std::stop_source stop;
  stop.request_stop();
  const Result<BenchReport> report = measure_field(quick(), {}, stop.get_token());
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace likeness
