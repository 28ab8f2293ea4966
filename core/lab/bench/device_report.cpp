// See device_report.h.
#include "core/lab/bench/device_report.h"

#include <fmt/format.h>

namespace likeness {

const char* precision_name(NetworkPrecision precision) {
  return precision == NetworkPrecision::bf16 ? "bf16" : "fp32";
}

namespace {

nlohmann::json to_json(const DevicePass& pass) {
  return {{"seconds", pass.seconds},
          {"floor_seconds", pass.floor_seconds},
          {"fraction_of_floor", pass.fraction_of_floor},
          {"msamples_s", pass.msamples_s}};
}

}  // namespace

nlohmann::json to_json(const DeviceBenchReport& report) {
  nlohmann::json speeds = nlohmann::json::array(), errors = nlohmann::json::array();
  for (const DeviceBatchSpeed& s : report.speeds)
    speeds.push_back({{"precision", precision_name(s.precision)},
                      {"samples", s.samples},
                      {"forward", to_json(s.inference)},
                      {"train", to_json(s.training)}});
  for (const DeviceFieldError& e : report.errors)
    errors.push_back({{"precision", precision_name(e.precision)},
                      {"outputs", e.outputs},
                      {"network_gradients", e.networks},
                      {"table_gradients", e.tables}});
  nlohmann::json frames = nlohmann::json::array();
  for (const DeviceFrameSpeed& s : report.frames)
    frames.push_back({{"quality", s.quality},
                      {"size", s.size},
                      {"samples", s.samples},
                      {"seconds", s.seconds},
                      {"frames_s", s.frames_s},
                      {"floor_seconds", s.floor_seconds},
                      {"fraction_of_floor", s.fraction_of_floor},
                      {"mean_error", s.mean_error},
                      {"share_over_0.02", s.share_over}});
  const DeviceFacts& f = report.facts;
  return {{"backend", "cuda"},
          {"machine",
           {{"gpu", f.name},
            {"compute_capability", fmt::format("{}.{}", f.major, f.minor)},
            {"multiprocessors", f.multiprocessors},
            {"memory_bytes", f.memory_bytes},
            {"driver", f.driver},
            {"toolkit", f.toolkit},
            {"bandwidth_gbs", report.ceilings.bandwidth_gbs},
            {"bf16_tflops", report.ceilings.matrix_tflops}}},
          {"field", {{"batches", speeds}, {"rel_l2", errors}}},
          {"frames", frames},
          {"step",
           {{"rays", report.step.rays},
            {"samples", report.step.samples},
            {"seconds", report.step.seconds},
            {"rays_by_processor_seconds", report.step.rays_by_processor_seconds},
            {"floor_seconds", report.step.floor_seconds},
            {"fraction_of_floor", report.step.fraction_of_floor},
            {"look_seconds", report.step.look_seconds}}}};
}

}  // namespace likeness
