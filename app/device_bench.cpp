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

std::vector<Table> device_tables(const DeviceBenchReport& report) {
  Table passes{
      .name = "passes",
      .title = fmt::format("{}, {:.0f} GB/s read and written, {:.0f} TFLOP/s of bf16 products",
                           report.facts.name, report.ceilings.bandwidth_gbs, report.ceilings.matrix_tflops)};
  passes.columns = {
      {"precision", "precision"}, {"samples", "batch", 0},         {"pass", "pass"},
      {"milliseconds", "ms", 3},  {"msamples_s", "Msamples/s", 1}, {"fraction_of_floor", "of floor", 3}};
  for (const DeviceBatchSpeed& s : report.speeds)
    for (const bool training : {false, true}) {
      const DevicePass& pass = training ? s.training : s.inference;
      passes.rows.push_back({precision_name(s.precision), double(s.samples),
                             training ? "training" : "forward", 1e3 * pass.seconds, pass.msamples_s,
                             pass.fraction_of_floor});
    }
  Table errors{.name = "errors", .title = "Relative L2 against double"};
  errors.columns = {{"precision", "precision"},
                    {"outputs", "outputs", -1},
                    {"network_gradients", "gradients of networks", -1},
                    {"table_gradients", "of tables", -1}};
  for (const DeviceFieldError& e : report.errors)
    errors.rows.push_back({precision_name(e.precision), e.outputs, e.networks, e.tables});
  Table frames{.name = "frames", .title = "Pictures"};
  frames.columns = {{"size_px", "px", 0},
                    {"quality", "quality"},
                    {"milliseconds", "ms"},
                    {"frames_s", "frames/s", 0},
                    {"fraction_of_floor", "of floor", 3},
                    {"mean_error", "off by", -1},
                    {"percent_over_0.02", "pixels off by more than 0.02, %"}};
  for (const DeviceFrameSpeed& s : report.frames)
    frames.rows.push_back({s.size, s.quality, 1e3 * s.seconds, s.frames_s, s.fraction_of_floor, s.mean_error,
                           100 * s.share_over});
  const DeviceStepSpeed& s = report.step;
  Table step{.name = "step", .title = "A step of training"};
  step.columns = {{"rays", "rays", 0},
                  {"samples", "samples", 0},
                  {"milliseconds", "ms"},
                  {"fraction_of_floor", "of floor", 3},
                  {"rays_by_processor_milliseconds", "with the processor's rays, ms"},
                  {"look_milliseconds", "an update of all cells, ms"}};
  step.rows = {{double(s.rays), double(s.samples), 1e3 * s.seconds, s.fraction_of_floor,
                1e3 * s.rays_by_processor_seconds, 1e3 * s.look_seconds}};
  return {std::move(passes), std::move(errors), std::move(frames), std::move(step)};
}

}  // namespace

int run_device_bench(const CommonOptions& common, const TableOptions& output,
                     const DeviceBenchOptions& options, const Project* project) {
  auto device = open_cuda_device();
  if (!device) return report_failure(device.error());
  std::optional<ProjectSpeed> speed;
  const auto report = [&]() -> Result<DeviceBenchReport> {
    const ProgressLine line(quiet_if_csv(common, output));
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
  nlohmann::json all = to_json(*report);
  all["project"] = speed ? project_speed_json(*speed) : nlohmann::json(nullptr);
  std::vector<Table> tables = device_tables(*report);
  if (speed) tables.push_back(project_speed_table(*speed));
  return report_tables(common, output, tables, &all);
}

}  // namespace likeness::app
