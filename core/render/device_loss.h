// The loss of rays and its gradients with respect to their samples, for processor and device. Plain C++17.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/field/device_kernels.h"
#include "core/render/composite.h"

namespace likeness {

// The parts of a field's batch that the loss reads and writes.
struct LossField {
  const float* sigma;   // (capacity)
  const float* colour;  // (3, capacity)
  float* d_sigma;       // (capacity)
  float* d_colour;      // (3, capacity)
  std::uint32_t capacity;
};

// Items: rays. The arrays are those of SampleBatch and RayBatch.
struct RayLossArgs {
  LossField field[2];
  const std::uint32_t* begin;        // (rays + 1)
  const float* dt;                   // (samples)
  const std::uint8_t* of_field;      // (samples)
  const std::uint32_t* slot;         // (samples)
  const float *target, *background;  // (rays, 3)
  const StepNumbers* numbers;
  StepSums* sums;  // the rays' squared errors are added
};

// Of ray r: writes its samples' gradients, returns its squared error over the channels.
LIKENESS_HOST_DEVICE inline double ray_loss(const RayLossArgs& a, std::size_t r) {
  const std::uint32_t first = a.begin[r], last = a.begin[r + 1];
  Composited<float> seen;
  float colour[3], d_sample[3], d_pixel[3];
  for (std::uint32_t i = first; i < last; ++i) {
    const LossField& f = a.field[a.of_field[i]];
    const std::size_t at = a.slot[i];
    for (int c = 0; c < 3; ++c) colour[c] = f.colour[std::size_t(c) * f.capacity + at];
    seen.add(f.sigma[at] * a.dt[i], colour);
  }
  double error = 0;
  for (int c = 0; c < 3; ++c) {
    const float difference =
        seen.colour[c] + seen.transmittance * a.background[3 * r + c] - a.target[3 * r + c];
    error += double(difference) * double(difference);
    d_pixel[c] = 2 * a.numbers->loss_scale * difference;
  }
  CompositeSlopes<float> slopes(seen, a.background + 3 * r, d_pixel, 0.0f);
  for (std::uint32_t i = first; i < last; ++i) {
    const LossField& f = a.field[a.of_field[i]];
    const std::size_t at = a.slot[i];
    for (int c = 0; c < 3; ++c) colour[c] = f.colour[std::size_t(c) * f.capacity + at];
    f.d_sigma[at] = a.dt[i] * slopes.next(f.sigma[at] * a.dt[i], colour, d_sample);
    for (int c = 0; c < 3; ++c) f.d_colour[std::size_t(c) * f.capacity + at] = d_sample[c];
  }
  return error;
}

}  // namespace likeness
