// The standard field on a device: how fast, beside what the device can do and how exact. What
// `likeness bench --backend cuda` reports. Times are the device's own, by its events.
#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/device/device.h"
#include "core/field/device_field.h"
#include "core/lab/bench/device_bench_options.h"
#include "core/lab/bench/device_frames.h"
#include "core/lab/bench/device_step.h"
#include "core/lab/bench/device_work.h"

namespace likeness {

struct DevicePass {
  double seconds = 0, floor_seconds = 0, fraction_of_floor = 0, msamples_s = 0;
};

struct DeviceBatchSpeed {
  std::size_t samples = 0;
  NetworkPrecision precision = NetworkPrecision::bf16;
  DevicePass inference, training;  // training: forward, backward and Adam, one recording
};

// Relative L2 against the reference in double, of samples that are not within rounding of a place without
// derivative.
struct DeviceFieldError {
  NetworkPrecision precision = NetworkPrecision::bf16;
  double outputs = 0, networks = 0, tables = 0;  // the worst output, the worst gradient of a block
};

struct DeviceBenchReport {
  DeviceFacts facts{};
  DeviceCeilings ceilings;
  std::vector<DeviceBatchSpeed> speeds;
  std::vector<DeviceFieldError> errors;
  std::vector<DeviceFrameSpeed> frames;
  DeviceStepSpeed step;
};

Result<DeviceBenchReport> measure_device(std::shared_ptr<Device> device, const DeviceBenchOptions& options,
                                         const Progress& progress, std::stop_token stop);

}  // namespace likeness
