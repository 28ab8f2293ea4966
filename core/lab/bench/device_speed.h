// The standard field on a device: how fast, beside what the device can do and how exact. What
// `likeness bench --backend cuda` reports. Times are the device's own, by its events.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/device/device.h"
#include "core/field/device_field.h"

namespace likeness {

struct DeviceBenchOptions {
  std::vector<std::size_t> batches = {131072, 1048576};  // samples
  int rounds = 20;                                       // of each figure; the median counts
  std::size_t ceiling_bytes = std::size_t{256} << 20;    // read and written as much
  int matrix_repeats = 4096;
  std::size_t error_samples = 1024;
  int frame_size = 512;                                       // px a side of the pictures
  int step_rays = 8192, step_views = 64, step_picture = 256;  // of a training's step; px a side
  int look_every = 1;                                         // cell into which a look goes
  std::uint32_t seed = 1;
};

struct DeviceCeilings {
  double bandwidth_gbs = 0;  // read and written
  double matrix_tflops = 0;  // products in bfloat16, sums in single precision; 0 without matrix units
};

// Least work of a pass over a batch: operations, and bytes that cannot but move: inputs and outputs of
// samples, every table entry that is needed once, every parameter that Adam touches and its moments.
struct DeviceWork {
  double flops = 0, bytes = 0;
};
DeviceWork inference_work(const FieldConfig& config, std::size_t samples);
DeviceWork training_work(const FieldConfig& config, std::size_t samples);
// Operations and bytes at once: the longer of the two. s
double floor_seconds(const DeviceWork& work, const DeviceCeilings& ceilings);

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

// A picture with a ray a pixel, as asked for by a render quality; see device_frames.h.
struct DeviceFrameSpeed {
  std::string quality;
  int size = 0;        // px a side
  double samples = 0;  // a frame
  double seconds = 0, frames_s = 0, floor_seconds = 0, fraction_of_floor = 0;
  double mean_error = 0, share_over = 0;  // of a pixel's worst channel; of pixels over two hundredths
};

// A training's step; see device_step.h.
struct DeviceStepSpeed {
  std::size_t rays = 0;
  double samples = 0;  // mean
  // By the wall, rays cast on the device, and by the processor.
  double seconds = 0, rays_by_processor_seconds = 0;
  double floor_seconds = 0, fraction_of_floor = 0;
  double look_seconds = 0;  // a look into all cells, every 32 steps
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
