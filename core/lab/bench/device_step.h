// Whole steps of a training on a device: how fast, beside their floor, with the rays cast there and by the
// processor. Part of `likeness bench --backend cuda` (device_speed.h).
#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>

#include "core/base/result.h"
#include "core/device/device.h"
#include "core/lab/bench/device_bench_options.h"
#include "core/lab/bench/device_work.h"

namespace likeness {

// A training's step.
struct DeviceStepSpeed {
  std::size_t rays = 0;
  double samples = 0;  // mean
  // By the wall, rays cast on the device, and by the processor.
  double seconds = 0, rays_by_processor_seconds = 0;
  double floor_seconds = 0, fraction_of_floor = 0;
  double look_seconds = 0;  // a look into all cells, every 32 steps
};

// The standard avatar (device_frames.h) learns from random pictures with mattes, of which its rays meet what
// a person's would: a step goes all the way, from conditions to the loss. Its face does not warp. The floor
// is that of the torso's field, the cheaper of the two, on as many samples (training_work).
Result<DeviceStepSpeed> measure_step(std::shared_ptr<Device> device, const DeviceCeilings& ceilings,
                                     const DeviceBenchOptions& options, std::stop_token stop);

}  // namespace likeness
