// likeness bench --backend cuda: see device_bench.h.
#include "app/device_bench.h"

#include <optional>

#include <fmt/format.h>

#include "app/project_speed_report.h"
#include "core/device/load_device.h"
#include "core/lab/bench/device_report.h"
#include "core/lab/bench/project_speed.h"
#include "core/render/backend.h"

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

int run_device_bench(const CommonOptions& common, const DeviceBenchOptions& options, const Project* project) {
  auto device = open_cuda_device();
  if (!device) return report_failure(device.error());
  std::optional<ProjectSpeed> speed;
  const auto report = [&]() -> Result<DeviceBenchReport> {
    const ProgressLine line(common);
    const std::stop_token stop = stop_on_signals();
    auto measured =
        measure_device(*device, options, line.progress().stage(0, project ? 0.5 : 1, "device"), stop);
    if (!measured || !project) return measured;
    ProjectSpeedOptions of_project;
    of_project.frames = 0;
    of_project.backend = device_backend(*device);
    const auto pictures =
        measure_project_speed(*project, of_project, line.progress().stage(0.5, 1, "project"), stop);
    if (!pictures) return pictures.error();
    speed = *pictures;
    return measured;
  }();
  if (!report) return report_failure(report.error());
  if (common.json) {
    nlohmann::json all = to_json(*report);
    all["project"] = speed ? project_speed_json(*speed) : nlohmann::json(nullptr);
    print_json(all);
  } else {
    print_report(*report);
    if (speed) print_project_speed(*speed);
  }
  return kExitDone;
}

}  // namespace likeness::app
