// likeness bench --backend cuda: see device_bench.h.
#include "app/device_bench.h"

#include <fmt/format.h>

#include "core/bench/device_report.h"
#include "core/device/load_device.h"

namespace likeness::app {
namespace {

void print_report(const DeviceBenchReport& report) {
  fmt::print(
      "{}, {:.0f} GB/s read and written, {:.0f} TFLOP/s of bf16 products\n\n{:>5} {:>8} {:<10} {:>10} {:>10} "
      "{:>9}\n",
      report.facts.name, report.ceilings.bandwidth_gbs, report.ceilings.matrix_tflops, "", "batch", "pass",
      "ms", "Msamples/s", "of floor");
  for (const DeviceBatchSpeed& s : report.speeds)
    for (const bool training : {false, true}) {
      const DevicePass& pass = training ? s.training : s.inference;
      fmt::print("{:>5} {:>8} {:<10} {:>10.3f} {:>10.1f} {:>9.3f}\n", precision_name(s.precision), s.samples,
                 training ? "training" : "forward", 1e3 * pass.seconds, pass.msamples_s,
                 pass.fraction_of_floor);
    }
  fmt::print("\n");
  for (const DeviceFieldError& e : report.errors)
    fmt::print(
        "relative L2 against double, {}: outputs {:.1e}, gradients of networks {:.1e} and tables {:.1e}\n",
        precision_name(e.precision), e.outputs, e.networks, e.tables);
  for (const DeviceFrameSpeed& s : report.frames)
    fmt::print(
        "{} x {} px, {}: {:.2f} ms a frame ({:.0f} frames/s), {:.3f} of the floor, off by {:.1e} on average, "
        "{:.2f} % of pixels by more than 0.02\n",
        s.size, s.size, s.quality, 1e3 * s.seconds, s.frames_s, s.fraction_of_floor, s.mean_error,
        100 * s.share_over);
  const DeviceStepSpeed& step = report.step;
  fmt::print(
      "a step of {} rays, {:.0f} samples: {:.2f} ms, {:.3f} of the floor; with the processor's rays {:.2f} "
      "ms; a "
      "look into all cells {:.2f} ms\n",
      step.rays, step.samples, 1e3 * step.seconds, step.fraction_of_floor,
      1e3 * step.rays_by_processor_seconds, 1e3 * step.look_seconds);
}

}  // namespace

int run_device_bench(const CommonOptions& common, const DeviceBenchOptions& options) {
  auto device = open_cuda_device();
  if (!device) return report_failure(device.error());
  const auto report = [&] {
    const ProgressLine line(common);
    return measure_device(*device, options, line.progress(), stop_on_signals());
  }();
  if (!report) return report_failure(report.error());
  if (common.json) {
    print_json(to_json(*report));
  } else {
    print_report(*report);
  }
  return kExitDone;
}

}  // namespace likeness::app
