// Claims about core/lab/bench/device_speed.h, on the emulated device: everything that is reported is
// measured, and a device that fails fails the measurement.
#include "core/lab/bench/device_speed.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/device/emulated_device.h"

namespace likeness {
namespace {

DeviceBenchOptions small_options() {
  DeviceBenchOptions options;
  options.batches = {64, 128};
  options.rounds = 1;
  options.ceiling_bytes = 4096;
  options.error_samples = 96;
  options.frame_size = 48;
  options.step_rays = 200, options.step_views = 3, options.step_picture = 48;
  options.look_every = 200;
  return options;
}

// Measured once for all that is claimed of it.
const Result<DeviceBenchReport>& small_report() {
  static const Result<DeviceBenchReport> report =
      measure_device(emulated_device(), small_options(), Progress(), {});
  return report;
}

TEST(DeviceSpeed, ReportsEveryBatchInBothPrecisionsWithItsError) {
  const auto& report = small_report();
  ASSERT_TRUE(report.ok()) << report.error().what;
  ASSERT_EQ(report->speeds.size(), 4u);
  for (const DeviceBatchSpeed& s : report->speeds)
    for (const DevicePass& pass : {s.inference, s.training}) {
      EXPECT_GT(pass.seconds, 0);
      EXPECT_GT(pass.floor_seconds, 0);
      EXPECT_NEAR(pass.fraction_of_floor, pass.floor_seconds / pass.seconds, 1e-12);
      EXPECT_NEAR(pass.msamples_s, 1e-6 * double(s.samples) / pass.seconds, 1e-9);
    }
  ASSERT_EQ(report->errors.size(), 2u);
  for (const DeviceFieldError& e : report->errors) {
    const double allowed = e.precision == NetworkPrecision::single ? 1e-5 : 2e-2;
    EXPECT_LE(e.outputs, allowed);
    EXPECT_LE(e.networks, allowed);
    EXPECT_LE(e.tables, allowed);
    EXPECT_GT(e.outputs, 0);
  }
}

TEST(DeviceSpeed, PicturesOfBothQualitiesAreTheProcessorsUpToTheirPrecision) {
  const auto& report = small_report();
  ASSERT_TRUE(report.ok()) << report.error().what;
  ASSERT_EQ(report->frames.size(), 2u);
  for (const DeviceFrameSpeed& s : report->frames) {
    EXPECT_GT(s.samples, 48 * 48) << s.quality;
    EXPECT_GT(s.floor_seconds, 0);
    EXPECT_NEAR(s.frames_s * s.seconds, 1, 1e-9);
    EXPECT_NEAR(s.fraction_of_floor, s.floor_seconds / s.seconds, 1e-12);
    EXPECT_GT(s.mean_error, 0);
    EXPECT_LT(s.mean_error, 5e-3);
    EXPECT_LT(s.share_over, 0.02);
  }
  EXPECT_GT(report->frames[0].samples, report->frames[1].samples);  // final has more of them
}

TEST(DeviceSpeed, AStepIsTimedBothWaysAndHasAFloor) {
  const auto& report = small_report();
  ASSERT_TRUE(report.ok()) << report.error().what;
  const DeviceStepSpeed& step = report->step;
  EXPECT_EQ(step.rays, 200u);
  EXPECT_GT(step.samples, 400);  // most rays meet the person
  EXPECT_LE(step.samples, 200 * 16);
  EXPECT_GT(step.seconds, 0);
  EXPECT_GT(step.rays_by_processor_seconds, 0);
  EXPECT_GT(step.look_seconds, 0);
  EXPECT_GT(step.floor_seconds, 0);
  EXPECT_NEAR(step.fraction_of_floor, step.floor_seconds / step.seconds, 1e-12);
}

TEST(DeviceSpeed, WithoutMatrixUnitsOnlySinglePrecisionIsMeasured) {
  DeviceBenchOptions options = small_options();
  options.batches = {64};
  const auto report = measure_device(emulated_device({.matrix_units = false}), options, Progress(), {});
  ASSERT_TRUE(report.ok());
  ASSERT_EQ(report->speeds.size(), 1u);
  EXPECT_EQ(report->speeds[0].precision, NetworkPrecision::single);
  EXPECT_EQ(report->ceilings.matrix_tflops, 0);
}

TEST(DeviceSpeed, ALostDeviceIsAnError) {
  const auto report = measure_device(emulated_device({.lost_after = 10}), small_options(), Progress(), {});
  ASSERT_FALSE(report.ok());
  EXPECT_NE(report.error().what.find("stopped responding"), std::string::npos);
}

}  // namespace
}  // namespace likeness
