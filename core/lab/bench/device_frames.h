// Pictures of a made-up avatar on a device: how fast, beside their floor, and how near to the processor's.
// Part of `likeness bench --backend cuda` (device_speed.h).
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/device/device.h"
#include "core/lab/bench/device_bench_options.h"
#include "core/lab/bench/device_work.h"
#include "core/render/avatar.h"
#include "core/render/backend.h"

namespace likeness {

// A picture with a ray a pixel, as asked for by a render quality.
struct DeviceFrameSpeed {
  std::string quality;
  int size = 0;        // px a side
  double samples = 0;  // a frame
  double seconds = 0, frames_s = 0, floor_seconds = 0, fraction_of_floor = 0;
  double mean_error = 0, share_over = 0;  // of a pixel's worst channel; of pixels over two hundredths
};

// The standard field (standard_field.h) as a head in a grid of 96^3 cells, of which an egg's are occupied,
// over a torso whose field takes no condition, in a picture of size x size pixels of which they fill about
// half.
Avatar standard_avatar(std::uint32_t seed, int size);

// A frame goes all the way: its pose to the device, the picture back. The floor is that of the torso's field,
// the cheaper of the two, on as many samples (inference_work). Error against the processor's picture with the
// same options in single precision.
Result<std::vector<DeviceFrameSpeed>> measure_frames(std::shared_ptr<Device> device,
                                                     const DeviceCeilings& ceilings,
                                                     const DeviceBenchOptions& options, std::stop_token stop);

}  // namespace likeness
