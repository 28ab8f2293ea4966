// Whole steps of a training on a device: how fast, beside their floor, with the rays cast there and by the
// processor. Part of `likeness bench --backend cuda` (device_speed.h).
#pragma once

#include <memory>
#include <stop_token>

#include "core/lab/bench/device_speed.h"

namespace likeness {

// The standard avatar (device_frames.h) learns from random pictures with mattes, of which its rays meet what
// a person's would: a step goes all the way, from conditions to the loss. Its face does not warp. The floor
// is that of the torso's field, the cheaper of the two, on as many samples (training_work).
Result<DeviceStepSpeed> measure_step(std::shared_ptr<Device> device, const DeviceCeilings& ceilings,
                                     const DeviceBenchOptions& options, std::stop_token stop);

}  // namespace likeness
